"""The facts about a contact from which its cause is determined."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchmarks.guard_oracle.bodies import part_touched
from benchmarks.guard_oracle.others import Other
from benchmarks.guard_oracle.world import World


@dataclass
class Contact:
    """The first contact of a drive, with the facts from which its cause is determined."""

    name: str
    role: str
    kind: str
    t: float
    part: str
    ego_speed: float
    closing: float
    their_part: str
    """Where the other was touched."""
    seen_s: float
    """How long the other had been in sight (s)."""
    seen_m: float
    """Distance that the ego had driven since then (m)."""
    seen_mps: float
    """The ego's speed when the other came into sight (m/s)."""
    from_start: bool
    follows: bool
    """Did the stack keep its distance to a leader?"""
    stood_s: float
    """How long the ego had been standing (s)."""
    room: float
    """Room that the other would have had beside us if we had gone straight since it could last stop behind us (m)."""
    order: str
    led_from_rails: bool = False
    """Did the drive start on rails, behind a vehicle that the stack follows?"""
    through: bool = False
    """Has the other driven through another actor?"""


def contact_with(world: World, other: Other, order: str, silent: bool) -> Contact:
    """The record of a contact that has just happened."""
    ego = world.ego
    vx, vy = ego.speed * math.cos(ego.yaw), ego.speed * math.sin(ego.yaw)
    seen = 0.0 if other.seen_at is None else world.t - other.seen_at
    return Contact(
        other.name,
        other.role,
        other.kind.value,
        world.t,
        part_touched(world.ego_body(), other.body),
        ego.speed,
        math.hypot(vx - other.vx, vy - other.vy),
        part_touched(other.body, world.ego_body()),
        seen,
        abs(world.ego_s - other.seen_from[0]),
        other.seen_from[1],
        other.seen_at == 0.0,
        ego.manner.follows,
        world.ego_stood,
        world.room_left_by(other),
        "silent" if silent else order,
        world.led_from_rails,
        other.name in world.through,
    )
