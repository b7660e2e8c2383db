"""The `stucksolver` program: parses the command line and runs one command."""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import os
import sys
from collections.abc import Collection, Sequence

from stucksolver.cli.arguments import SUPPORTED, Parser, installed_version
from stucksolver.cli.commands import COMMANDS
from stucksolver.cli.errors import UsageError
from stucksolver.cli.keys import send_key, without_logins
from stucksolver.privacy.addresses import shown

PIPE_CLOSED = 128 + 13
"""The exit code that shells report for a program killed by SIGPIPE."""
EXIT_CODES = (
    "exit codes: 0 success; 1 the command ran, but the result is bad (a route crashed, a record does not match, a "
    "required package is missing); 2 wrong usage or invalid input; 130 interrupted; 141 the output was closed early"
)
WITHOUT_SETTINGS = ("config", "completion")
"""Commands that take no settings because they describe the settings themselves."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code. `arguments` defaults to those of the process."""
    told = without_logins(sys.argv[1:] if arguments is None else list(arguments))
    named = [word for word in told if word in COMMANDS][:1]
    parser = _parser(filled=named)
    try:
        options = _parse(parser, told, named[0]) if named else parser.parse_args(told)
        if getattr(options, "send_key", False):
            send_key(options)
        if options.drives:
            _require_client()
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        print("\ninterrupted", file=sys.stderr)
        return 130
    except UsageError as error:
        print(f"error: {shown(str(error))}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # The reader closed the pipe. Without this, Python would report the error again when it closes the stream.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED


def full_parser() -> argparse.ArgumentParser:
    """Return the program's parser with the options of every command, for completion, settings and documentation."""
    return _parser()


def _parse(parser: argparse.ArgumentParser, told: Sequence[str], command: str) -> argparse.Namespace:
    """Parse the options; file and environment provide what the command line omits. Raises `UsageError`."""
    from stucksolver.cli import settings

    before = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    before.add_argument("--config")
    early, _ = before.parse_known_args(list(itertools.takewhile(lambda word: word != command, told)))
    if command in WITHOUT_SETTINGS:
        return parser.parse_args(told)
    file = settings.find_file(early.config)
    content = settings.read_file(file) if file else {}
    if file:
        settings.check_file(file, content, list(settings.settings_of("", full_parser())))
    mine = [one for one in settings.settings_of("", parser) if one.section.split(".")[0] == command]
    values = [(one, settings.given(one, content, file)) for one in mine]
    settings.put_in(parser, [(one, value) for one, value in values if value])
    options = parser.parse_args(told)
    used = settings.taken_out(parser, options)
    if used:
        told_of = ", ".join(f"{name} {value}" for name, value in used)
        print(f"note: settings used: {shown(told_of)}", file=sys.stderr)
    return options


def _parser(filled: Collection[str] = tuple(COMMANDS)) -> argparse.ArgumentParser:
    """Return the parser. Only the named commands get their options, so that the others need not be imported."""
    parser = Parser(prog="stucksolver", description="Gets immobilized vehicles moving again.", epilog=EXIT_CODES)
    parser.add_argument("--version", action="version", version=f"%(prog)s {installed_version()}")
    parser.add_argument(
        "--config", metavar="FILE", help="configuration file instead of stucksolver.toml; `none` reads no file"
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        one = commands.add_parser(name, help=command.about, description=command.more or command.about)
        if name in filled:
            command.fill(one)
    return parser


def _require_client() -> None:
    if importlib.util.find_spec("carla") is None:
        raise UsageError(
            f"the carla package is not installed; it exists for {SUPPORTED}: add the extra [sim] (README, Install)"
        )
