"""`stucksolver voice`: installs a speech recognizer that runs in the browser, for the passenger's page."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from stucksolver.commands.arguments import add_json, print_json
from stucksolver.commands.subcommands import parts_of, run_part


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parts_of(parser)
    put = _with_folder(add("install", "download it with npm (42 MB, pinned version and digest)", _install))
    put.add_argument(
        "--from", dest="source", type=Path, metavar="DIR", help="install from archives of `npm pack` in DIR instead"
    )
    status = _with_folder(add("status", "check that it is installed and complete", _status))
    add_json(status, '{"folder": path, "installed": true or false}')
    _with_folder(add("remove", "delete it", _remove))


def run(options: argparse.Namespace) -> int:
    """Run the requested subcommand and return its exit code. Raises `UsageError`."""
    from stucksolver_passenger.speech_recognizer import RecognizerError

    return run_part(options, RecognizerError)


def _with_folder(parser: argparse.ArgumentParser) -> argparse.ArgumentParser:
    parser.add_argument("--folder", type=Path, metavar="DIR", help="folder to use instead of the user's data folder")
    return parser


def _install(options: argparse.Namespace) -> int:
    from stucksolver_passenger.speech_recognizer import PACKAGES, from_folder, install

    for package in PACKAGES:
        print(f"downloading {package.title}", file=sys.stderr, flush=True)
    found = install(options.folder, None if options.source is None else from_folder(options.source))
    print(f"{found.folder}: installed; pages opened from now on recognize speech locally")
    return 0


def _status(options: argparse.Namespace) -> int:
    from stucksolver_passenger.speech_recognizer import find_recognizer, usual_folder

    found = find_recognizer(options.folder)
    folder = options.folder or usual_folder() if found is None else found.folder
    if options.json:
        print_json({"folder": folder, "installed": found is not None})
    elif found is None:
        print(f"recognizer missing or incomplete: {folder}. Run stucksolver voice install")
    else:
        print(f"{folder}: installed")
    return int(found is None)


def _remove(options: argparse.Namespace) -> int:
    from stucksolver_passenger.speech_recognizer import remove

    print("removed" if remove(options.folder) else "not installed")
    return 0
