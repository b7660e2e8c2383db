"""Registry of the kinds of reasoners that commands and configuration files can name."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from stucksolver.plugins import PluginError, plugins
from stucksolver.privacy.url_redaction import redacted
from stucksolver.reasoners.reasoner import Reasoner


class ReasonerNameError(ValueError):
    """Unknown or unusable reasoner. The message has the remedy."""


@dataclass(frozen=True)
class ReasonerKind:
    """Kind of a reasoner.

    Attributes:
        name: Name before the first colon.
        form: Notation for help texts.
        make: `make(rest, exchanges)` creates a reasoner from the text after the colon. Requests to a model are stored
            in the folder `exchanges`, if given. It raises `ReasonerNameError`.
        sees: `sees(rest)` is True if the reasoner uses the camera's images.
    """

    name: str
    form: str
    make: Callable[[str, Path | None], Reasoner]
    sees: Callable[[str], bool] = lambda rest: False


KINDS: dict[str, ReasonerKind] = {}


def register(kind: ReasonerKind) -> None:
    """Register a kind of reasoner.

    Raises:
        ValueError: The name is already registered.
    """
    if kind.name in KINDS:
        raise ValueError(f"there is already a kind of reasoner named {kind.name!r}")
    KINDS[kind.name] = kind


def load_plugins() -> None:
    """Register the kinds that other installed distributions add.

    A plug-in that cannot be loaded is left out, because the vehicle must keep its built-in rules. `stucksolver plugins`
    reports the reason.
    """
    for plugin in plugins("reasoners"):
        with contextlib.suppress(PluginError):
            kind = plugin.load()
            if kind.name not in KINDS:
                register(kind)


def help_text() -> str:
    """Return the notations of the registered kinds in one line."""
    return f"{', '.join(kind.form for kind in KINDS.values())}, or several in order of trust, separated by commas"


def kind_of(word: str) -> tuple[ReasonerKind, str]:
    """Return the kind of a name, and the text after its colon.

    Raises:
        ReasonerNameError: The kind is unknown.
    """
    name, _, rest = word.partition(":")
    kind = KINDS.get(name)
    if kind is None:
        raise ReasonerNameError(f"unknown reasoner {redacted(word)!r}: use {help_text()}")
    return kind, rest
