"""The `stucksolver` program: parses the command line and runs one command."""

from __future__ import annotations

import argparse
import importlib.util
import io
import itertools
import os
import sys
from collections.abc import Collection, Mapping, Sequence
from typing import TypeAlias

from stucksolver.commands.arguments import SUPPORTED, Parser, installed_version
from stucksolver.commands.command_table import CliCommand, commands
from stucksolver.commands.errors import UsageError
from stucksolver.plugins import PluginError
from stucksolver.privacy.url_redaction import redacted, without_logins

PIPE_CLOSED = 128 + 13
"""Exit code that shells report for a program killed by SIGPIPE."""
EXIT_CODES = (
    "exit codes: 0 success; 1 the command ran, but the result is bad (a route crashed, a record does not match, a "
    "required package is missing); 2 wrong usage or invalid input; 130 interrupted; 141 the output was closed early"
)
PROGRAM = "stucksolver"
Table: TypeAlias = Mapping[str, CliCommand]
WITHOUT_SETTINGS = ("config", "completion")
"""Commands without settings, because they describe the settings themselves."""


def main(arguments: Sequence[str] | None = None, *, program: str = PROGRAM, table: Table | None = None) -> int:
    """Run the command line and return the exit code.

    Args:
        arguments: Arguments; those of the process if None.
        program: Name of the program in messages.
        table: Commands by name; those of all installed distributions if None.
    """
    for stream in (sys.stdout, sys.stderr):
        # A terminal whose encoding lacks a character shows a question mark instead of ending the command.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    # Logins leave the arguments first, so that no later message can contain them.
    words = without_logins(sys.argv[1:] if arguments is None else list(arguments))
    try:
        known = commands() if table is None else table
        named = [word for word in words if word in known][:1]
        parser = _parser(program, known, filled=named)
        options = _parse(parser, words, named[0], known) if named else parser.parse_args(words)
        # Preparation of an option that several commands share.
        getattr(options, "prepare", lambda _: None)(options)
        if options.drives:
            _require_client()
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        print("\ninterrupted", file=sys.stderr)
        return 130
    except (UsageError, PluginError) as error:
        print(f"error: {redacted(str(error))}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # The reader closed the pipe. Otherwise Python reports the error again when it closes the stream.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED


def full_parser(program: str = PROGRAM, table: Table | None = None) -> argparse.ArgumentParser:
    """Return a program's parser with the options of every command, for completion, settings and documentation."""
    known = commands() if table is None else table
    return _parser(program, known, filled=known)


def _parse(parser: argparse.ArgumentParser, words: Sequence[str], command: str, known: Table) -> argparse.Namespace:
    """Return the options; file and environment provide what the command line omits. Raises `UsageError`."""
    from stucksolver.commands import settings

    before = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    before.add_argument("--config")
    early, _ = before.parse_known_args(list(itertools.takewhile(lambda word: word != command, words)))
    if command in WITHOUT_SETTINGS:
        return parser.parse_args(words)
    file = settings.find_file(early.config)
    content = settings.read_file(file) if file else {}
    if file:
        settings.check_file(file, content, list(settings.settings_of("", full_parser(table={**commands(), **known}))))
    mine = [setting for setting in settings.settings_of("", parser) if setting.section.split(".")[0] == command]
    values = [(item, settings.lookup(item, content, file)) for item in mine]
    settings.put_in(parser, [(item, value) for item, value in values if value])
    options = parser.parse_args(words)
    used = settings.taken_out(parser, options)
    if used:
        summary = ", ".join(f"{name} {value}" for name, value in used)
        print(f"note: settings used: {redacted(summary)}", file=sys.stderr)
    return options


def _parser(program: str, known: Table, filled: Collection[str]) -> argparse.ArgumentParser:
    """Return the parser. Only the commands in `filled` get their options, so that no other command is imported."""
    parser = Parser(prog=program, description="Gets immobilized vehicles moving again.", epilog=EXIT_CODES)
    parser.add_argument("--version", action="version", version=f"%(prog)s {installed_version()}")
    parser.add_argument(
        "--config", metavar="FILE", help="configuration file instead of stucksolver.toml; `none` reads no file"
    )
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, command in known.items():
        subparser = subparsers.add_parser(name, help=command.about, description=command.more or command.about)
        if name in filled:
            command.fill(subparser)
    return parser


def _require_client() -> None:
    if importlib.util.find_spec("carla") is None:
        raise UsageError(
            f"the carla package is not installed; it exists for {SUPPORTED}: add the extra [carla] (README, Install)"
        )
