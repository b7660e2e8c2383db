"""The kinds of reasoners that commands and configuration files can name. Each says so in its own file, in one call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from stucksolver.reason.reasoner import Reasoner


class ReasonerNameError(ValueError):
    """No such reasoner; the message lists what there is."""


@dataclass(frozen=True)
class Kind:
    """A kind of reasoner.

    `name`: the word before the first colon. `form`: what to write, for help texts. `make(rest, exchanges)`: makes one
    of what stands after that colon; requests to a model are kept in the folder `exchanges`, if one is given; raises
    `ReasonerNameError`. `sees(rest)`: does it look at the camera's pictures?
    """

    name: str
    form: str
    make: Callable[[str, Path | None], Reasoner]
    sees: Callable[[str], bool] = lambda rest: False


KINDS: dict[str, Kind] = {}


def register(kind: Kind) -> None:
    """Let a kind be named. Raises `ValueError` for a name that is taken."""
    if kind.name in KINDS:
        raise ValueError(f"there is a kind of reasoner named {kind.name!r} already")
    KINDS[kind.name] = kind


def help_text() -> str:
    """What can be written, in a line."""
    return f"{', '.join(kind.form for kind in KINDS.values())}, or several in order of trust, separated by commas"


def kind_of(word: str) -> tuple[Kind, str]:
    """The kind of one word, and what stands after its colon. Raises `ReasonerNameError`."""
    name, _, rest = word.partition(":")
    kind = KINDS.get(name)
    if kind is None:
        raise ReasonerNameError(f"unknown reasoner {word!r}: use {help_text()}")
    return kind, rest
