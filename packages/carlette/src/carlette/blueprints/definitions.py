"""Actor definitions: the entries of a blueprint library."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class AttributeType(IntEnum):
    """Types of an attribute; `ClientVersion.attribute_type_offset` is added on the wire."""

    BOOL = 0
    INT = 1
    FLOAT = 2
    STRING = 3
    COLOR = 4


@dataclass(frozen=True)
class Attribute:
    """One attribute of a blueprint, with its default as text."""

    id: str
    type: AttributeType
    value: str
    recommended: tuple[str, ...] = ()
    is_modifiable: bool = False
    is_restricted: bool = False


@dataclass(frozen=True)
class Definition:
    """One kind of actor that a client can spawn."""

    id: str
    attributes: tuple[Attribute, ...]
    more_tags: tuple[str, ...] = ()

    @property
    def tags(self) -> str:
        """The tags: as in CARLA, the parts of the id; carlette's own blueprints have one more."""
        return ",".join((*self.id.split("."), *self.more_tags))


def text(id: str, value: str) -> Attribute:
    """Return a fixed text attribute."""
    return Attribute(id, AttributeType.STRING, value)


def integer(id: str, value: int) -> Attribute:
    """Return a fixed integer attribute."""
    return Attribute(id, AttributeType.INT, str(value))


def flag(id: str, value: bool) -> Attribute:
    """Return a fixed boolean attribute."""
    return Attribute(id, AttributeType.BOOL, str(value).lower())


def number(id: str, value: float, *, modifiable: bool = False) -> Attribute:
    """Return a float attribute."""
    return Attribute(id, AttributeType.FLOAT, f"{value:g}", is_modifiable=modifiable)


def option(id: str, type: AttributeType, value: str, *recommended: str) -> Attribute:
    """Return an attribute that the client may set to any value."""
    return Attribute(id, type, value, recommended, is_modifiable=True)


def role_name(value: str, *recommended: str) -> Attribute:
    """Return the role name, which every actor has. Scenario code finds its actors by it."""
    return option("role_name", AttributeType.STRING, value, *recommended)
