"""`stucksolver`: the program."""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
from collections.abc import Collection, Sequence

from stucksolver.cli.arguments import SUPPORTED, Parser, installed_version
from stucksolver.cli.commands import COMMANDS
from stucksolver.cli.errors import UsageError

PIPE_CLOSED = 128 + 13
"""As a shell has it for a program that ends by SIGPIPE."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of the `stucksolver` command; returns the exit code."""
    told = sys.argv[1:] if arguments is None else list(arguments)
    options = _parser(filled=[word for word in told if word in COMMANDS][:1]).parse_args(told)
    try:
        if options.drives:
            _require_client()
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        print("\ninterrupted", file=sys.stderr)
        return 130
    except UsageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # Whoever read the output has had enough. Python would complain once more while it closes the stream.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED


def _parser(filled: Collection[str] = tuple(COMMANDS)) -> argparse.ArgumentParser:
    """The parser; only the commands named have their options, since those of others need not be imported."""
    parser = Parser(prog="stucksolver", description="Gets immobilized vehicles moving again.")
    parser.add_argument("--version", action="version", version=f"%(prog)s {installed_version()}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        one = commands.add_parser(name, help=command.about, description=command.more or command.about)
        if name in filled:
            command.fill(one)
    return parser


def _require_client() -> None:
    if importlib.util.find_spec("carla") is None:
        raise UsageError(
            f"the carla package is not installed; it exists for {SUPPORTED}: pip install 'stucksolver[sim]'"
        )
