"""Names of drivers and clocks that several commands accept, and notes to the user."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from stucksolver.commands.errors import UsageError
from stucksolver.solver import make_clock

USUAL = "normal"
PROFILES = ("cautious", USUAL, "aggressive")


def driver_name(text: str) -> str:
    """Return a driver's full name: `behavior:PROFILE`, or any other text unchanged. Raises `UsageError`."""
    name, _, profile = text.partition(":")
    if name == "behavior":
        if (profile or USUAL) not in PROFILES:
            raise UsageError(f"unknown driver: {text!r}. Use behavior, or behavior: with one of {', '.join(PROFILES)}")
        return f"behavior:{profile or USUAL}"
    # The current folder is searched for agents too, as `python -m` does.
    sys.path.append(os.getcwd())
    return text


def clock_name(text: str) -> str:
    """Return a clock's full name. Raises `UsageError`."""
    try:
        return make_clock(text).name
    except ValueError as error:
        raise UsageError(str(error)) from error


def print_notes(notes: Sequence[str]) -> None:
    """Print notes for the user before a drive, one per line on standard error."""
    for note in notes:
        print(f"note: {note}", file=sys.stderr, flush=True)
