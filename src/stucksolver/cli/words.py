"""Words that several commands take."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from stucksolver.cli.errors import UsageError
from stucksolver.solver import make_clock

PROFILES = ("cautious", "normal", "aggressive")


def driver_profile(text: str) -> str:
    """Of `behavior` or `behavior:PROFILE`. Raises `UsageError`."""
    name, _, profile = text.partition(":")
    if name != "behavior" or (profile or "normal") not in PROFILES:
        raise UsageError(f"unknown driver {text!r}: use behavior, or behavior: with one of {', '.join(PROFILES)}")
    return profile or "normal"


def clock_name(text: str) -> str:
    """A clock's full name. Raises `UsageError`."""
    try:
        return make_clock(text).name
    except ValueError as error:
        raise UsageError(str(error)) from error


def tell_notes(notes: Sequence[str]) -> None:
    """What a person should know before a drive, each on a line of its own."""
    for note in notes:
        print(f"note: {note}", file=sys.stderr, flush=True)
