"""Copies a model of unknown origin with bounded effort and without calling any code of its values.

The scene of a stack and the answer of a reasoner may have been created without validation. Their fields may then hold
anything: a million entries, lists that contain themselves, objects whose attributes raise.
"""

from __future__ import annotations

import base64
from collections.abc import Iterator
from enum import Enum
from functools import cache
from typing import Any, TypeVar, get_args, get_origin

from pydantic import ValidationError

from stucksolver.scene.base_model import FrozenModel, RegisteredModels, first_problem

M = TypeVar("M", bound=FrozenModel)
Location = tuple[Any, str]
"""Location of a value: location of its container, and its name in it. It becomes a text only in an error."""
MOST_VALUES = 200_000
"""Maximum number of values in a model. A scene has about 40 for each object. Ours."""
MOST_CHARACTERS = 16_000_000
"""Maximum number of characters in a model. A camera image has a million, the prompt of a model 50,000. Ours."""
DEEPEST = 24
"""Maximum nesting depth of lists and models. The JSON schema of a behavior is 8 deep. Ours."""
LARGEST_INT = 2**63
"""Upper bound for the size of a whole number: no message has a larger one."""


class MalformedError(ValueError):
    """Malformed model. The message is one line and names the first field that is wrong."""


def read_again(value: object, kind: type[M], most_values: int = MOST_VALUES) -> M:
    """Return a validated copy of a model.

    Args:
        value: Claimed model of that class.
        kind: Class of the model.
        most_values: Maximum number of values in the model.

    Raises:
        MalformedError: The value has another class, is too large, is nested too deeply, or contains a rejected value.
    """
    try:
        if type(value) is not kind:
            raise MalformedError(f"a {type(value).__name__}, not a {kind.__name__}")
        return kind.model_validate(_Reader(kind, most_values).read(value, (None, kind.__name__), 0))
    except ValidationError as error:
        raise MalformedError(first_problem(error)) from error
    except MalformedError:
        raise
    except Exception as error:
        raise MalformedError(f"it cannot be read ({type(error).__name__})") from error


class _Reader:
    """Converts a model to plain values and counts them."""

    def __init__(self, kind: type[FrozenModel], most_values: int) -> None:
        self._known = known_types(kind)
        self._values, self._characters = most_values, MOST_CHARACTERS

    def read(self, value: Any, location: Location, depth: int) -> Any:
        """Return the plain form of a value. `location` is its position, for the message."""
        kind = type(value)
        if kind is float:
            return value
        if value is None or kind is bool or (kind in self._known and issubclass(kind, Enum)):
            return value
        if kind is str or kind is bytes:
            self._characters -= len(value)
            if self._characters < 0:
                raise MalformedError(f"{_named(location)}: more than {MOST_CHARACTERS} characters in all")
            return _encodable(value, location) if kind is str else base64.b64encode(value)
        if issubclass(kind, float) and not issubclass(kind, Enum):
            return float.__float__(value)
        if issubclass(kind, int) and not issubclass(kind, Enum):
            number = int.__index__(value)
            if abs(number) > LARGEST_INT:
                raise MalformedError(f"{_named(location)}: a number beyond all bounds")
            return number
        if depth >= DEEPEST:
            raise MalformedError(f"{_named(location)}: nested more than {DEEPEST} deep")
        return self._read_many(value, kind, location, depth + 1)

    def _read_many(self, value: Any, kind: type, location: Location, depth: int) -> Any:
        if kind is tuple or kind is list:
            self._count(len(value), location)
            return [self.read(item, (location, f"[{k}]"), depth) for k, item in enumerate(value)]
        if kind is dict and dict in self._known:
            self._count(len(value), location)
            if any(type(name) is not str for name in value):
                raise MalformedError(f"{_named(location)}: a name that is not a text")
            return {
                _encodable(name, location): self.read(item, (location, f"[{name[:40]!a}]"), depth)
                for name, item in value.items()
            }
        if kind not in self._known:
            raise MalformedError(f"{_named(location)}: a {kind.__name__} has no place here")
        content = object.__getattribute__(value, "__dict__")
        fields = [name for name in kind.model_fields if name in content]  # type: ignore[attr-defined]
        self._count(len(fields), location)
        return {name: self.read(content[name], (location, f".{name}"), depth) for name in fields}

    def _count(self, many: int, location: Location) -> None:
        self._values -= many
        if self._values < 0:
            raise MalformedError(f"{_named(location)}: too many values in all")


def _named(location: Location | None) -> str:
    """Return a location as text, such as `RecoveryPlan.behaviors[0].speed_mps`."""
    names: list[str] = []
    while location is not None:
        location, name = location
        names.append(name)
    return "".join(reversed(names))


def _encodable(text: str, location: Location) -> str:
    """Return the text if a record can store it.

    Raises:
        MalformedError: The text has characters without an encoding in UTF-8.
    """
    if text.isascii():
        return text
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise MalformedError(f"{_named(location)}: characters that no record can hold") from error
    return text


def known_types(kind: type[FrozenModel]) -> frozenset[type]:
    """Return the models, the enumerations and the mappings that may occur in a model, by its fields' annotations."""
    found: set[type] = set()
    waiting: list[type[FrozenModel]] = [kind]
    while waiting:
        annotated, registered = _annotated_types(waiting.pop())
        found |= annotated
        waiting += [model for item in registered for model in item.models() if model not in found]
    return frozenset(found)


@cache
def _annotated_types(kind: type[FrozenModel]) -> tuple[frozenset[type], frozenset[RegisteredModels]]:
    """Return the types that may occur in a model, without the registered models, and the annotations of these."""
    types: set[type] = set()
    registered: set[RegisteredModels] = set()
    waiting: list[type] = [kind]
    while waiting:
        item = waiting.pop()
        if item in types:
            continue
        types.add(item)
        if issubclass(item, FrozenModel):
            for field in item.model_fields.values():
                for part in _parts(field.annotation, tuple(field.metadata)):
                    if isinstance(part, RegisteredModels):
                        registered.add(part)
                    elif issubclass(part, (FrozenModel, Enum, dict)):
                        waiting.append(part)
    return frozenset(types), frozenset(registered)


def _parts(annotation: Any, metadata: tuple[Any, ...] = ()) -> Iterator[type | RegisteredModels]:
    """Yield the classes in an annotation. An annotation of registered models stands for the class that it annotates."""
    inner = get_args(annotation)
    registered = [item for item in (*metadata, *inner) if isinstance(item, RegisteredModels)]
    if registered:
        yield from registered
        return
    if get_origin(annotation) is dict:
        yield dict
    if not inner and isinstance(annotation, type):
        yield annotation
    for item in inner:
        yield from _parts(item)
