"""Finds the line of a value in a TOML file, because the parser does not report line numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence

_HEADING = re.compile(r"^\s*(\[\[?)\s*([^\]]+?)\s*\]\]?\s*(?:#.*)?$")
_KEY = re.compile(r"^\s*([A-Za-z0-9_.\-\"']+?)\s*=")


def line_of(text: str, key_path: Sequence[int | str]) -> int:
    """Return the line (from 1) of the deepest part of a path like ("rung", 2, "tries") that is in the file, or 1."""
    paths = _paths(text)
    first_below = [number for number, path in paths if path[: len(key_path)] == tuple(key_path)]
    best, depth = (first_below[0] if first_below and key_path else 1), 0
    for number, path in paths:
        agreeing = _agreeing(path, key_path)
        if agreeing == len(path) and agreeing > depth:
            best, depth = number, agreeing
    return best


def _paths(text: str) -> list[tuple[int, tuple[int | str, ...]]]:
    """Return every heading and key with its full path; the tables of a list are counted from 0."""
    paths: list[tuple[int, tuple[int | str, ...]]] = []
    counts: dict[str, int] = {}
    table: tuple[int | str, ...] = ()
    for number, line in enumerate(text.splitlines(), 1):
        heading, key = _HEADING.match(line), _KEY.match(line)
        if heading:
            name = heading.group(2)
            table = tuple(name.split("."))
            if heading.group(1) == "[[":
                counts[name] = counts.get(name, -1) + 1
                table = (*table, counts[name])
            paths.append((number, table))
        elif key:
            paths.append((number, (*table, *key.group(1).strip("\"'").split("."))))
    return paths


def _agreeing(path: tuple[int | str, ...], key_path: Sequence[int | str]) -> int:
    """Return the number of leading parts that the two paths share."""
    shared = 0
    for item, other in zip(path, key_path, strict=False):
        if item != other:
            break
        shared += 1
    return shared
