"""Reads JSON of unknown origin: any text gives a value or one error of one line."""

from __future__ import annotations

import json
from typing import Any, NoReturn

DEEPEST = 100
"""Lists and objects may be nested this deep. Ours are nested up to 15 deep; what walks over them is recursive."""


class JsonError(ValueError):
    """A text is not JSON, or cannot be used. The message is one line."""


def read_json(text: str | bytes) -> Any:
    """Return the value of a JSON text.

    Raises:
        JsonError: It is no JSON, holds a number that is none, or is nested too deeply.
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
    """Return how deep lists and objects are nested in a value; 0 for one without any. Stops one beyond `DEEPEST`."""
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
