"""`stucksolver words`: prints the interpretation of passengers' utterances."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from stucksolver.commands.errors import UsageError
from stucksolver.commands.json_lines import json_lines
from stucksolver.interpreter import Interpreter, NoInterpreter, find_reader
from stucksolver.scene import Scene
from stucksolver.solver.situation_text import situation_text


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="IN.jsonl",
        help='JSON lines: {"situation": a sentence or a scene, "text": an utterance}; - reads standard input',
    )


def run(options: argparse.Namespace) -> int:
    """Print one interpretation per line as JSON. Returns 0. Raises `UsageError` for an invalid line."""
    reader = find_reader()
    if isinstance(reader, NoInterpreter):
        raise UsageError(reader.why)
    for where, entry in json_lines(options.file):
        print(_read(reader, entry, where), flush=True)
    return 0


def _read(reader: Interpreter, entry: dict[str, Any], where: str) -> str:
    try:
        text, situation = entry["text"], entry.get("situation", "")
        if isinstance(situation, dict):
            situation = situation_text(Scene.model_validate(situation))
        if not isinstance(text, str) or not isinstance(situation, str):
            raise TypeError("text and situation must be strings")
    except (ValueError, KeyError, TypeError, AttributeError, ValidationError) as error:
        what = f"{type(error).__name__}: {str(error).splitlines()[0]}"
        raise UsageError(f'{where}: {what}. Expected {{"situation": "...", "text": "..."}}') from error
    return reader.read(text, situation).model_dump_json()
