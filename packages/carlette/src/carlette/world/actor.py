"""Actors: the state of each object of the world apart from its motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

from carlette.blueprints import AttributeType
from carlette.geometry import Box, Pose
from carlette.physics.vehicle_parameters import PhysicsParameters


class ActorKind(IntEnum):
    """Role of an actor in the world."""

    OTHER = 0
    VEHICLE = 1
    WALKER = 2
    LIGHT = 3
    SIGN = 4
    PROP = 5
    SENSOR = 6


Attributes = dict[str, tuple[AttributeType, str]]


@dataclass(eq=False)
class Actor:
    """One actor. Its pose and velocity are row `row` of the world's bodies."""

    id: int
    type_id: str
    kind: ActorKind
    row: int
    box: Box
    attributes: Attributes = field(default_factory=dict)
    tags: bytes = b""
    """Semantic tags (`CityObjectLabel`)."""
    parent_id: int = 0
    """Id of the parent; 0 = none."""
    attached: Pose | None = None
    """Pose in the parent's frame, if it has a parent that was not destroyed."""
    stream_id: int = 0
    """Stream of a sensor; 0 = none."""
    index: int = -1
    """Row in the table of its kind (fleet, walkers, lights)."""
    touches: bool = False
    """True if others can collide with the actor, unless a client switches its collisions off."""
    posed: dict[str, Pose] = field(default_factory=dict)
    """Joints that a client (or a flagger's gesture) has set, each in its parent bone's frame."""
    blend: float = 0.0
    """Share of that pose: 0 for the usual stance, 1 for the whole pose."""
    physics: PhysicsParameters | None = None
    """A vehicle's technical data in the form of the client."""
    surface: int = -1
    """Row in the table of the ground below; -1 = not on the ground."""
