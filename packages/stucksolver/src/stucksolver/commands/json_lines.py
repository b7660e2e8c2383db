"""Reads files of JSON lines."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from stucksolver.commands.errors import UsageError
from stucksolver.scene.json_text import JsonError, read_json


def json_lines(file: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the position ("FILE:NUMBER") and the object of each line; `-` is standard input. Raises `UsageError`."""
    try:
        text = sys.stdin.read() if str(file) == "-" else file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{file} cannot be read: {error}; give a file of JSON lines") from error
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        location = f"{file}:{number}"
        try:
            data = read_json(line)
        except JsonError as error:
            raise UsageError(f"{location}: invalid JSON: {error}") from error
        if not isinstance(data, dict):
            raise UsageError(f"{location}: expected an object, got {type(data).__name__}")
        yield location, data
