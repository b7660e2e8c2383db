"""Computes how far a vehicle can drive along a path before its box touches another one, without numpy."""

from __future__ import annotations

import math
from typing import Collection, Sequence

from stucksolver_bridge.actor_boxes import PlacedBox
from stucksolver_bridge.path_line import PathLine

STEP_M = 0.75
"""Travel between two tests for contact (m). Ours."""
MARGIN_M = 0.15
"""Clearance at the vehicle's sides (m). Ours."""
SEPARATION_M = 1.0
"""Travel after which a box that touches the vehicle now must be clear or farther away (m). Otherwise the vehicle would
push it. Ours."""
CLEAR_BELOW_M, CLEAR_ABOVE_M = 1.0, 2.3
"""Boxes that end this far below the vehicle's underside, or begin this far above it, are on another level (m). Ours."""


def free_way_m(
    line: PathLine,
    s: float,
    reach_m: float,
    half_size_m: tuple[float, float],
    foot_z: float,
    bodies: Sequence[PlacedBox],
    ignore: Collection[int] = (),
    backwards: bool = False,
) -> float:
    """Return the travel along the line from `s` until the vehicle's box touches another; `inf` if it touches none.

    A box that already touches the vehicle, or is within the margin next to it, counts only if the path leads into it.
    So the vehicle can drive away from contact, but cannot push.
    """
    levelled = [b for b in bodies if b.body.actor.id not in ignore and _same_level(b, foot_z)]
    if not levelled:
        return math.inf
    body = (half_size_m[0], half_size_m[1] + MARGIN_M)
    close_boxes = _touched(line, s, body, levelled, backwards)
    touching = _touched(line, s, half_size_m, close_boxes, backwards)
    if any(_nearer(line, s, b) for b in _touched(line, s + SEPARATION_M, half_size_m, touching, backwards)):
        return 0.0
    apart = [b for b in levelled if b not in close_boxes]
    alongside = [b for b in close_boxes if b not in touching]
    travel = STEP_M
    while (apart or alongside) and travel <= reach_m + STEP_M:
        at_s = s + travel
        if _touched(line, at_s, body, apart, backwards) or _touched(line, at_s, half_size_m, alongside, backwards):
            return max(travel - STEP_M, 0.0)
        travel += STEP_M
    return math.inf


def _nearer(line: PathLine, s: float, other: PlacedBox) -> bool:
    """Return True if the path leads toward the center of a box."""
    (x, y, _), (next_x, next_y, _) = line.at(s), line.at(s + SEPARATION_M)
    return math.hypot(other.x - next_x, other.y - next_y) < math.hypot(other.x - x, other.y - y)


def _same_level(body: PlacedBox, foot_z: float) -> bool:
    half = body.body.half_height_m
    return body.z + half > foot_z - CLEAR_BELOW_M and body.z - half < foot_z + CLEAR_ABOVE_M


def _touched(
    line: PathLine, s: float, half_size_m: tuple[float, float], bodies: Sequence[PlacedBox], backwards: bool
) -> list[PlacedBox]:
    x, y, yaw = line.at(s)
    if backwards:
        yaw += math.pi
    length, width = half_size_m
    return [b for b in bodies if _overlap(x, y, yaw, length, width, b)]


def _overlap(x: float, y: float, yaw: float, length: float, width: float, other: PlacedBox) -> bool:
    """Return True if two rectangles overlap, by the separating axis theorem."""
    dx, dy = other.x - x, other.y - y
    far = math.hypot(length, width) + math.hypot(other.body.half_length_m, other.body.half_width_m)
    if dx * dx + dy * dy > far * far:
        return False
    cos, sin = math.cos(yaw), math.sin(yaw)
    turn = other.yaw_rad - yaw
    c, n = abs(math.cos(turn)), abs(math.sin(turn))
    a, b = other.body.half_length_m, other.body.half_width_m
    along, aside = dx * cos + dy * sin, dy * cos - dx * sin
    if abs(along) > length + a * c + b * n or abs(aside) > width + a * n + b * c:
        return False
    along_other = along * math.cos(turn) + aside * math.sin(turn)
    aside_other = aside * math.cos(turn) - along * math.sin(turn)
    return abs(along_other) <= a + length * c + width * n and abs(aside_other) <= b + length * n + width * c
