"""`stucksolver voice`: a speech recognizer for the passenger's page, which runs in the browser."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from stucksolver.cli.arguments import Parser
from stucksolver.cli.errors import UsageError


def add_options(parser: argparse.ArgumentParser) -> None:
    """What the command is told."""
    parts = parser.add_subparsers(required=True, metavar="PART", help="what to do", parser_class=Parser)
    put = _add(parts.add_parser("install", help="fetch it by npm (42 MB), pinned by version and digest"), _install)
    put.add_argument("--from", dest="source", type=Path, metavar="DIR", help="archives of `npm pack`, instead of npm")
    _add(parts.add_parser("status", help="check that it is installed and complete"), _status)
    _add(parts.add_parser("remove", help="delete it"), _remove)


def run(options: argparse.Namespace) -> int:
    """Do the part that was asked for. Raises `UsageError`."""
    from stucksolver.passenger.recognizer import RecognizerError

    try:
        return int(options.part(options))
    except RecognizerError as error:
        raise UsageError(str(error)) from error


def _add(parser: argparse.ArgumentParser, part: object) -> argparse.ArgumentParser:
    parser.set_defaults(part=part)
    parser.add_argument("--folder", type=Path, metavar="DIR", help="instead of the user's data folder")
    return parser


def _install(options: argparse.Namespace) -> int:
    from stucksolver.passenger.recognizer import PACKAGES, from_folder, install

    for package in PACKAGES:
        print(f"fetching {package.title}", file=sys.stderr, flush=True)
    found = install(options.folder, None if options.source is None else from_folder(options.source))
    print(f"{found.folder}: installed; pages that are opened from now on recognize speech by themselves")
    return 0


def _status(options: argparse.Namespace) -> int:
    from stucksolver.passenger.recognizer import find_recognizer, usual_folder

    found = find_recognizer(options.folder)
    if found is None:
        print(f"{options.folder or usual_folder()}: no recognizer, or an incomplete one; run stucksolver voice install")
        return 1
    print(f"{found.folder}: installed")
    return 0


def _remove(options: argparse.Namespace) -> int:
    from stucksolver.passenger.recognizer import remove

    print("removed" if remove(options.folder) else "there was none")
    return 0
