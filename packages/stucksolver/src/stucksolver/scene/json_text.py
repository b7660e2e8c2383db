"""Reads JSON of unknown origin: any text gives a value or one error of one line."""

from __future__ import annotations

import json
from typing import Any, NoReturn

DEEPEST = 100
"""Maximum nesting depth of lists and objects. Records are up to 15 deep; the code that visits them is recursive."""


class JsonError(ValueError):
    """Text that is not JSON or cannot be used. The message is one line."""


def read_json(text: str | bytes) -> Any:
    """Return the value of a JSON text.

    Raises:
        JsonError: The text is not JSON, contains NaN or an infinity, or is nested too deeply.
    """
    try:
        value = json.loads(text, parse_constant=_refuse)
    except JsonError:
        raise
    except RecursionError as error:
        raise JsonError(f"nested more than {DEEPEST} deep") from error
    except ValueError as error:
        raise JsonError(" ".join(str(error).split())[:200]) from error
    if depth_of(value) > DEEPEST:
        raise JsonError(f"nested more than {DEEPEST} deep")
    return value


def depth_of(value: Any) -> int:
    """Return the nesting depth of lists and objects in a value; 0 without any. Counting stops beyond `DEEPEST`."""
    level, depth = [value], 0
    while depth <= DEEPEST:
        inner: list[Any] = []
        nested = False
        for item in level:
            if isinstance(item, (dict, list)):
                nested = True
                inner += item.values() if isinstance(item, dict) else item
        if not nested:
            break
        level, depth = inner, depth + 1
    return depth


def _refuse(name: str) -> NoReturn:
    raise JsonError(f"{name} is not a number in JSON")
