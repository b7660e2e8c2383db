"""Traffic lights: post, arm, heads. In the actor's frame x runs across the lanes and +y points back at the traffic."""

from __future__ import annotations

import math
from functools import lru_cache

from carlette.camera.models.mesh import Builder, Color, Mesh, Point
from carlette.camera.rendering import tags
from carlette.geometry import Vector

CASE: Color = (34, 36, 38)
POST: Color = (96, 100, 104)
ARM_Z_M = 5.35
"""Height of the arm (m). Ours."""
POST_HEAD_Z_M = 2.75
"""Height of the head on the post (m). Ours."""
LONGEST_ARM_M = 10.0
"""Longest arm (m). Ours."""
REPEATER_HEAD: Point = (0.0, 0.14, 3.0)
HEAD_HALF = Vector(0.31, 0.2, 0.66)
"""Half size of a head's box, with back plate and hoods (m). Ours."""
LAMPS: tuple[tuple[Color, Color], ...] = (
    ((255, 36, 24), (70, 18, 16)),
    ((255, 190, 20), (72, 56, 14)),
    ((30, 240, 120), (14, 60, 34)),
)
"""Lit and dark, from top to bottom: red, yellow, green, in the order of `carla.TrafficLightState`."""


def post_mesh(arm_m: float) -> Mesh:
    """Return the post at the origin and an arm to `arm_m` along x."""
    builder = Builder(tags.POLE)
    arm = max(-LONGEST_ARM_M, min(LONGEST_ARM_M, arm_m))
    builder.cylinder((0, 0, -0.8), (0, 0, ARM_Z_M + 0.7), 0.11, POST, sides=8, tip=0.08)
    if abs(arm) > 0.6:
        builder.limb((0.0, 0.0, ARM_Z_M + 0.55), (arm, 0.0, ARM_Z_M + 0.62), 0.1, 0.1, POST)
    builder.tag = tags.TRAFFIC_LIGHT
    for place in heads(arm_m):
        _case(builder, place)
    return builder.mesh()


def heads(arm_m: float) -> list[Point]:
    """Return middles of the heads: one over the lanes, one on the post."""
    arm = max(-LONGEST_ARM_M, min(LONGEST_ARM_M, arm_m))
    low = (0.0, 0.16, POST_HEAD_Z_M)
    return [(arm, 0.10, ARM_Z_M), low] if abs(arm) > 0.6 else [(0.0, 0.16, ARM_Z_M - 1.2), low]


def lamps_mesh(arm_m: float, color: int) -> tuple[Mesh, Mesh]:
    """Return the lamps with `color` lit (0 red, 1 yellow, 2 green, otherwise none), and the halos of the lit ones."""
    return _lamps(heads(arm_m), color)


@lru_cache(maxsize=1)
def repeater_mesh() -> Mesh:
    """Return a second post with one head, at the origin."""
    builder = Builder(tags.POLE)
    builder.cylinder((0, 0, -0.8), (0, 0, REPEATER_HEAD[2] + 0.7), 0.08, POST, sides=8, tip=0.07)
    builder.tag = tags.TRAFFIC_LIGHT
    _case(builder, REPEATER_HEAD)
    return builder.mesh()


def repeater_lamps_mesh(color: int) -> tuple[Mesh, Mesh]:
    """Return the same as `lamps_mesh` for the post of `repeater_mesh`."""
    return _lamps([REPEATER_HEAD], color)


def _lamps(places: list[Point], color: int) -> tuple[Mesh, Mesh]:
    builder, halos = Builder(tags.TRAFFIC_LIGHT), Builder(tags.TRAFFIC_LIGHT)
    for x, y, z in places:
        for number, (lit, dark) in enumerate(LAMPS):
            on = number == color
            at = (x, y + 0.17, z + 0.36 * (1 - number))
            builder.disc(at, 0.145, (0, 1.0, 0), lit if on else dark, sides=12, glow=on)
            if on:
                middle = (at[0], at[1] + 0.06, at[2])
                ring = [(middle[0] + 0.5 * math.cos(a), middle[1], middle[2] + 0.5 * math.sin(a)) for a in _TURNS]
                halos.spot(middle, ring, lit, (0, 1.0, 0), 170)
    return builder.mesh(), halos.mesh()


def _case(builder: Builder, place: Point) -> None:
    x, y, z = place
    builder.box((x, y - 0.02, z), (0.62, 0.03, 1.32), (20, 21, 22))
    builder.box((x, y + 0.06, z), (0.40, 0.2, 1.14), CASE)
    for number in range(3):
        up = z + 0.36 * (1 - number) + 0.165
        builder.box((x, y + 0.25, up), (0.34, 0.2, 0.025), CASE)


_TURNS = [math.pi * item / 5 for item in range(10)]
