"""Words that several commands take."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from stucksolver.cli.errors import UsageError
from stucksolver.solver import make_clock

USUAL = "normal"
PROFILES = ("cautious", USUAL, "aggressive")


def driver_name(text: str) -> str:
    """A driver's full name: `behavior:PROFILE`, or `MODULE:CLASS` as it is. Raises `UsageError`."""
    name, _, profile = text.partition(":")
    if name == "behavior":
        if (profile or USUAL) not in PROFILES:
            raise UsageError(f"unknown driver {text!r}: use behavior, or behavior: with one of {', '.join(PROFILES)}")
        return f"behavior:{profile or USUAL}"
    # As with `python -m`: agents lie in the folder in which the command is given, too.
    sys.path.append(os.getcwd())
    return text


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
