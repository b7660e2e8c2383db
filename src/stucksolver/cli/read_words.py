"""`stucksolver words`: what a passenger's words are read as."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from stucksolver.cli.errors import UsageError
from stucksolver.scene import Scene
from stucksolver.words import NoReader, WordsReader, find_reader, situation_of

ABOUT = "read a passenger's words: lines of situation and text in, readings out"


def add_words(commands: Any) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser("words", help=ABOUT, description=ABOUT)
    parser.add_argument(
        "file",
        type=Path,
        metavar="IN.jsonl",
        help='a line each: {"situation": a sentence or a scene, "text": words}; - reads standard input',
    )
    return parser


def run_words(options: argparse.Namespace) -> int:
    """Print one reading a line as JSON. Raises `UsageError` for what cannot be read."""
    reader = find_reader()
    if isinstance(reader, NoReader):
        raise UsageError(reader.why)
    for number, line in enumerate(_lines(options.file), 1):
        if line.strip():
            print(_read(reader, line, f"{options.file}:{number}"), flush=True)
    return 0


def _lines(file: Path) -> list[str]:
    try:
        text = sys.stdin.read() if str(file) == "-" else file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{file}: cannot be read: {error}; give a file of JSON lines") from error
    return text.splitlines()


def _read(reader: WordsReader, line: str, where: str) -> str:
    try:
        said = json.loads(line)
        text, situation = said["text"], said.get("situation", "")
        if isinstance(situation, dict):
            situation = situation_of(Scene.model_validate(situation))
        if not isinstance(text, str) or not isinstance(situation, str):
            raise TypeError("text and situation must be strings")
    except (ValueError, KeyError, TypeError, AttributeError, ValidationError) as error:
        what = f"{type(error).__name__}: {str(error).splitlines()[0]}"
        raise UsageError(f'{where}: {what}; a line is {{"situation": "...", "text": "..."}}') from error
    return reader.read(text, situation).model_dump_json()
