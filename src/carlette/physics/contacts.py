"""What happens when bodies touch: they are pushed apart and exchange momentum."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from carlette.geometry import Vector
from carlette.physics.bodies import Bodies
from carlette.physics.overlap import Boxes, Indices, boxes_of, near_pairs, overlaps

BOUNCE = 0.1
FRICTION = 0.4
SLOP_M = 0.005
STILL_MPS = 0.01
ROUNDS = 2
"""Pushing one pair apart may press another together; a second round settles a queue."""


class Contact(NamedTuple):
    """Two bodies that hit each other in this tick."""

    first: int
    second: int
    """Rows in `Bodies`."""
    impulse: Vector
    """On the second body, N·s, world frame; the first got the opposite."""


def collide(bodies: Bodies) -> list[Contact]:
    """Resolves all contacts between solid bodies and reports those with an impulse."""
    rows = np.flatnonzero(bodies.solid)
    hits: dict[tuple[int, int], Vector] = {}
    for _ in range(ROUNDS):
        speed = np.abs(bodies.velocity[rows, :2]).max(axis=1, initial=0.0)
        moving = (speed > STILL_MPS) & (bodies.mass[rows] > 0)
        boxes = boxes_of(bodies, rows)
        first, second = near_pairs(boxes, moving)
        if not len(first):
            break
        found = overlaps(boxes, first, second)
        if not len(found.first):
            break
        for i, j, normal, depth in zip(found.first, found.second, found.normal, found.depth, strict=True):
            pair = (int(rows[i]), int(rows[j]))
            impulse = _resolve(bodies, boxes, (int(i), int(j)), pair, (float(normal[0]), float(normal[1])), depth)
            if impulse is not None:
                hits[pair] = impulse.plus(hits.get(pair, Vector()))
    return [Contact(*pair, impulse) for pair, impulse in hits.items()]


def _resolve(
    bodies: Bodies,
    boxes: Boxes,
    index: tuple[int, int],
    pair: tuple[int, int],
    normal: tuple[float, float],
    depth: float,
) -> Vector | None:
    """Separates a pair and applies the impulse of the hit; None where they only rest on each other."""
    inverse = [_inverse_mass(bodies, row) for row in pair]
    total = inverse[0] + inverse[1]
    if total == 0.0:
        return None
    away = np.array(normal)
    shift = max(depth - SLOP_M, 0.0) / total * away
    bodies.position[pair[0], :2] -= inverse[0] * shift
    bodies.position[pair[1], :2] += inverse[1] * shift
    point = _touch_point(boxes, index)
    arms = [point - boxes.center[one] for one in index]
    return _exchange(bodies, pair, inverse, arms, away)


def _exchange(
    bodies: Bodies, pair: tuple[int, int], inverse: list[float], arms: list[np.ndarray], away: np.ndarray
) -> Vector | None:
    spin = [one * _inverse_inertia(bodies, row) for one, row in zip(inverse, pair, strict=True)]
    closing = _speed_at(bodies, pair[1], arms[1]) - _speed_at(bodies, pair[0], arms[0])
    normal_speed = float(closing @ away)
    if normal_speed >= -1e-3:
        return None
    size = -(1.0 + BOUNCE) * normal_speed / _give(inverse, spin, arms, away)
    side = np.array([-away[1], away[0]])
    drag = -float(closing @ side) / _give(inverse, spin, arms, side)
    drag = float(np.clip(drag, -FRICTION * size, FRICTION * size))
    impulse = size * away + drag * side
    for row, arm, one, turn, sign in zip(pair, arms, inverse, spin, (-1.0, 1.0), strict=True):
        bodies.velocity[row, :2] += sign * one * impulse
        bodies.angular[row, 2] += sign * np.degrees(turn * _cross(arm, impulse))
    return Vector(float(impulse[0]), float(impulse[1]), 0.0)


def _give(inverse: list[float], spin: list[float], arms: list[np.ndarray], along: np.ndarray) -> float:
    """How much a pair's speed along a direction changes for each N·s."""
    turning = sum(turn * _cross(arm, along) ** 2 for turn, arm in zip(spin, arms, strict=True))
    return inverse[0] + inverse[1] + turning


def _speed_at(bodies: Bodies, row: int, arm: np.ndarray) -> np.ndarray:
    rate = np.radians(bodies.angular[row, 2])
    moved: np.ndarray = bodies.velocity[row, :2] + rate * np.array([-arm[1], arm[0]])
    return moved


def _inverse_mass(bodies: Bodies, row: int) -> float:
    mass = float(bodies.mass[row])
    return 1.0 / mass if mass > 0 and bodies.simulated[row] else 0.0


def _inverse_inertia(bodies: Bodies, row: int) -> float:
    """Mass over moment of inertia of a rectangle."""
    half = bodies.extent[row]
    return 3.0 / float(half[0] ** 2 + half[1] ** 2)


def _touch_point(boxes: Boxes, index: tuple[int, int]) -> np.ndarray:
    """The middle of the corners of each box that lie within the other."""
    inside = [corner for a, b in (index, index[::-1]) for corner in _corners(boxes, a) if _within(boxes, b, corner)]
    if not inside:
        return (boxes.center[index[0]] + boxes.center[index[1]]) / 2.0
    return np.mean(inside, axis=0)


def _corners(boxes: Boxes, one: int) -> list[np.ndarray]:
    ahead = boxes.ahead[one] * boxes.half[one, 0]
    left = np.array([-boxes.ahead[one, 1], boxes.ahead[one, 0]]) * boxes.half[one, 1]
    return [boxes.center[one] + a * ahead + b * left for a in (-1, 1) for b in (-1, 1)]


def _within(boxes: Boxes, one: int, point: np.ndarray) -> bool:
    gap = point - boxes.center[one]
    ahead = boxes.ahead[one]
    along, across = float(gap @ ahead), _cross(ahead, gap)
    return abs(along) <= boxes.half[one, 0] and abs(across) <= boxes.half[one, 1]


def _cross(a: np.ndarray, b: np.ndarray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def is_free(bodies: Bodies, candidate: Bodies) -> bool:
    """True when the single solid body of `candidate` would overlap no solid body."""
    rows: Indices = np.flatnonzero(bodies.solid)
    there, new = boxes_of(bodies, rows), boxes_of(candidate, np.zeros(1, np.int64))
    both = Boxes(*(np.concatenate(pair) for pair in zip(new, there, strict=True)))
    moving = np.zeros(len(both.center), bool)
    moving[0] = True
    first, second = near_pairs(both, moving)
    return not len(overlaps(both, first, second).first)
