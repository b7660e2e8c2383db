"""The kinds of reasoners that commands and configuration files can name."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from stucksolver.plugins import PluginError, plugins
from stucksolver.privacy.url_redaction import shown
from stucksolver.reasoners.reasoner import Reasoner


class ReasonerNameError(ValueError):
    """There is no such reasoner, or it cannot be used. The message says what to do."""


@dataclass(frozen=True)
class ReasonerKind:
    """A kind of reasoner.

    Attributes:
        name: The part before the first colon.
        form: How to write it, for help texts.
        make: `make(rest, exchanges)` makes a reasoner from the text after the colon. Requests to a model are stored in
            the folder `exchanges`, if given. It raises `ReasonerNameError`.
        sees: `sees(rest)` is True if it uses the camera's images.
    """

    name: str
    form: str
    make: Callable[[str, Path | None], Reasoner]
    sees: Callable[[str], bool] = lambda rest: False


KINDS: dict[str, ReasonerKind] = {}


def register(kind: ReasonerKind) -> None:
    """Register a kind of reasoner.

    Raises:
        ValueError: The name is taken.
    """
    if kind.name in KINDS:
        raise ValueError(f"there is already a kind of reasoner named {kind.name!r}")
    KINDS[kind.name] = kind


def load_plugins() -> None:
    """Register the kinds that other installed distributions add.

    A plug-in that cannot be loaded must not keep the vehicle without its built-in rules: it is left out, and
    `stucksolver plugins` says why.
    """
    for plugin in plugins("reasoners"):
        with contextlib.suppress(PluginError):
            kind = plugin.load()
            if kind.name not in KINDS:
                register(kind)


def help_text() -> str:
    """Return in one line what names can be given."""
    return f"{', '.join(kind.form for kind in KINDS.values())}, or several in order of trust, separated by commas"


def kind_of(word: str) -> tuple[ReasonerKind, str]:
    """Return the kind that a name denotes, and the text after its colon.

    Raises:
        ReasonerNameError: There is no such kind.
    """
    name, _, rest = word.partition(":")
    kind = KINDS.get(name)
    if kind is None:
        raise ReasonerNameError(f"unknown reasoner {shown(word)!r}: use {help_text()}")
    return kind, rest
