"""Reads a ladder from its file and reports the file, the line and the remedy of each error."""

from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Iterable
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from stucksolver.ladder.ladder import Ladder
from stucksolver.ladder.rungs import KINDS
from stucksolver.ladder.toml_lines import line_of

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PROFILES = ("default", "evaluation")


class LadderError(ValueError):
    """Error in a ladder. The message has the file, the line and the remedy."""


def find_ladder(source: Ladder | Path | str | None) -> Ladder:
    """Return a ladder.

    Args:
        source: Ladder, name of a profile that ships with the package, or file. None is the default profile.

    Raises:
        LadderError: The profile or file does not exist, or the file has an error.
    """
    if isinstance(source, Ladder):
        return source
    if source is None or source in PROFILES:
        return profile(str(source or PROFILES[0]))
    return load_ladder(Path(source))


def profile(name: str) -> Ladder:
    """Return one of `PROFILES`.

    Raises:
        LadderError: The profile does not exist.
    """
    return parse_ladder(profile_text(name), f"{name}.toml")


def profile_text(name: str) -> str:
    """Return the text of one of `PROFILES`, as a starting point for another ladder.

    Raises:
        LadderError: The profile does not exist.
    """
    if name not in PROFILES:
        raise LadderError(f"unknown ladder {name!r}: use {', '.join(PROFILES)}, or a file")
    return resources.files("stucksolver.ladder").joinpath(f"{name}.toml").read_text(encoding="utf-8")


def load_ladder(path: Path) -> Ladder:
    """Read a ladder from a file.

    Raises:
        LadderError: The file cannot be read or has an error.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        hint = f"use {', '.join(PROFILES)}, or a file; `stucksolver ladder default` prints one to start from"
        raise LadderError(f"no ladder {path}: {hint}") from error
    except (OSError, UnicodeDecodeError) as error:
        raise LadderError(f"cannot read the ladder {path}: {error}; give a text file in UTF-8") from error
    return parse_ladder(text, str(path))


def parse_ladder(text: str, file: str) -> Ladder:
    """Parse a ladder from the text of a file. `file` is its name for error messages.

    Raises:
        LadderError: The text has an error.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        position = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        line = int(position.group(1)) if position else text.count("\n") + 1
        problem = re.sub(r"\s*\(at .*\)", "", str(error))
        raise LadderError(f"{file}, line {line}: invalid TOML: {problem}; fix that line") from error
    try:
        return Ladder.model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        location = [part for part in first["loc"] if part not in KINDS]
        line = line_of(text, location)
        raise LadderError(f"{file}, line {line}: {_name(location)}: {_problem(first, location)}") from error


def _name(location: Iterable[int | str]) -> str:
    """Return the name of a value with indices from 1, as a reader of the file counts: `rung 3, deadline_s`."""
    parts: list[str] = []
    for part in location:
        if isinstance(part, int) and parts:
            parts[-1] += f" {part + 1}"
        elif part != "[key]":
            parts.append(str(part))
    return ", ".join(parts) or "the ladder"


def _problem(error: Any, location: list[int | str]) -> str:
    """Return the problem with its remedy."""
    message = str(error["msg"]).removeprefix("Value error, ")
    if error["type"] == "extra_forbidden":
        keys = _known_keys(location)
        near = difflib.get_close_matches(str(location[-1]), keys, n=1)
        remedy = f"did you mean {near[0]}?" if near else f"remove it; known here: {', '.join(keys)}"
        return f"unknown key; {remedy}"
    if error["type"] == "missing":
        return "this key is missing; add it"
    if error["type"] in ("union_tag_invalid", "union_tag_not_found"):
        return f"kind must be one of {', '.join(KINDS)}"
    return (
        f"{message[0].lower()}{message[1:]}, not {error['input']!r}" if "Value error" not in error["msg"] else message
    )


def _known_keys(location: list[int | str]) -> list[str]:
    """Return the keys that are allowed at the position of an unknown key."""
    if location[0] == "rung":
        return sorted({key for kind in KINDS.values() for key in kind.model_fields})
    model: type[BaseModel] = Ladder
    for part in location[:-1]:
        field = model.model_fields.get(str(part))
        inner = field.annotation if field else None
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            break
        model = inner
    return sorted(field.alias or name for name, field in model.model_fields.items())
