"""`stucksolver ladder`: prints a shipped ladder, or checks a ladder file."""

from __future__ import annotations

import argparse
from pathlib import Path

from stucksolver.commands.arguments import add_json, print_json
from stucksolver.commands.errors import UsageError
from stucksolver.ladder import PROFILES, Ladder, LadderError, find_ladder, profile_text


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("ladder", nargs="?", default="default", help=f"{', '.join(PROFILES)} or a file")
    add_json(parser, 'the ladder with every value, {"name", "rungs": [{"kind", ...}], ...}')


def run(options: argparse.Namespace) -> int:
    """Print the file of a profile, or check a file and list its rungs. Returns 0. Raises `UsageError`."""
    if options.json:
        print_json(chosen_ladder(options.ladder).model_dump(mode="json"))
        return 0
    if options.ladder in PROFILES:
        print(profile_text(options.ladder), end="")
        return 0
    ladder = chosen_ladder(options.ladder)
    print(f"{options.ladder}: ladder {ladder.name!r} is valid")
    for number, rung in enumerate(ladder.rungs, 1):
        values = ", ".join(f"{k} {_plain(v)}" for k, v in rung.model_dump(mode="json").items() if k != "kind")
        print(f"{number}. {rung.kind}: {rung.summary}" + (f" ({values})" if values else ""))
    return 0


def chosen_ladder(text: str) -> Ladder:
    """Return the ladder of this profile or file. Raises `UsageError`."""
    try:
        return find_ladder(text if text in PROFILES else Path(text))
    except LadderError as error:
        raise UsageError(str(error)) from error


def _plain(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value).lower()
