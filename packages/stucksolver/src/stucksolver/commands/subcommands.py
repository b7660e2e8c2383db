"""Commands with several subcommands, such as `stucksolver memory list`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TypeAlias

from stucksolver.commands.arguments import Parser
from stucksolver.commands.errors import UsageError

Part: TypeAlias = Callable[[argparse.Namespace], int]
"""Runs a subcommand and returns the exit code."""
AddPart: TypeAlias = Callable[[str, str, Part], argparse.ArgumentParser]
"""Adds a subcommand by its name and help, and returns its parser."""


def parts_of(parser: argparse.ArgumentParser) -> AddPart:
    """Give a command several subcommands. Returns the function that adds each of them."""
    parts = parser.add_subparsers(required=True, metavar="SUBCOMMAND", help="action", parser_class=Parser)

    def add(name: str, about: str, part: Part) -> argparse.ArgumentParser:
        added = parts.add_parser(name, help=about)
        added.set_defaults(part=part)
        return added

    return add


def run_part(options: argparse.Namespace, *mistakes: type[Exception]) -> int:
    """Run the requested subcommand, and return its exit code.

    Args:
        options: Parsed options.
        *mistakes: Errors that the user can correct.

    Raises:
        UsageError: One of these errors.
    """
    try:
        return int(options.part(options))
    except mistakes as error:
        raise UsageError(str(error)) from error
