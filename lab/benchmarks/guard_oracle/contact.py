"""The facts about a contact that determine its cause."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lab.benchmarks.guard_oracle.bodies import part_touched
from lab.benchmarks.guard_oracle.others import Other
from lab.benchmarks.guard_oracle.world import World


@dataclass
class Contact:
    """The first contact of a drive."""

    name: str
    role: str
    kind: str
    t: float
    part: str
    """Touched part of the ego."""
    their_part: str
    """Touched part of the other."""
    ego_speed: float
    closing: float
    order: str


def contact_with(world: World, other: Other, order: str) -> Contact:
    """Return the record of a contact that has just happened. `order`: directive that the ego executed."""
    ego = world.ego
    vx, vy = ego.speed * math.cos(ego.yaw), ego.speed * math.sin(ego.yaw)
    return Contact(
        other.name,
        other.role,
        other.kind.value,
        world.t,
        part_touched(world.ego_body(), other.body),
        part_touched(other.body, world.ego_body()),
        ego.speed,
        math.hypot(vx - other.vx, vy - other.vy),
        order,
    )
