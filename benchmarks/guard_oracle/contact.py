"""What a contact was like: all that its cause is told from."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchmarks.guard_oracle.bodies import part_touched
from benchmarks.guard_oracle.others import Other
from benchmarks.guard_oracle.world import World


@dataclass
class Contact:
    """The first contact of a drive, with all that its cause is told from."""

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
    """For how long the other had been in sight."""
    seen_m: float
    """How far the ego had come since."""
    seen_mps: float
    """How quick it was when the other came into sight."""
    from_start: bool
    follows: bool
    """Did the stack keep its distance to who goes ahead?"""
    stood_s: float
    """For how long the ego had been standing."""
    room: float
    """What the other would have had beside us, had we gone straight on since they could last stop behind us (m)."""
    order: str
    led_from_rails: bool = False
    """Did the drive begin on rails, behind somebody whom the stack follows?"""
    through: bool = False
    """Has the other driven through somebody else?"""


def contact_with(world: World, other: Other, order: str, silent: bool) -> Contact:
    """The record of a contact that has just been made."""
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
