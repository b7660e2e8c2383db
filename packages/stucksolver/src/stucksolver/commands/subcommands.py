"""Commands that consist of several parts, such as `stucksolver memory list`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TypeAlias

from stucksolver.commands.arguments import Parser
from stucksolver.commands.errors import UsageError

Part: TypeAlias = Callable[[argparse.Namespace], int]
"""Runs a part of a command and returns the exit code."""
AddPart: TypeAlias = Callable[[str, str, Part], argparse.ArgumentParser]
"""Adds a part by its name and help, and returns its parser."""


def parts_of(parser: argparse.ArgumentParser) -> AddPart:
    """Make a command one that consists of parts. Returns the function that adds each of them."""
    parts = parser.add_subparsers(required=True, metavar="SUBCOMMAND", help="what to do", parser_class=Parser)

    def add(name: str, what: str, part: Part) -> argparse.ArgumentParser:
        added = parts.add_parser(name, help=what)
        added.set_defaults(part=part)
        return added

    return add


def run_part(options: argparse.Namespace, *mistakes: type[Exception]) -> int:
    """Run the part that was asked for, and return its exit code.

    Args:
        options: What was parsed.
        *mistakes: Errors that are the user's to correct.

    Raises:
        UsageError: One of these errors.
    """
    try:
        return int(options.part(options))
    except mistakes as error:
        raise UsageError(str(error)) from error
