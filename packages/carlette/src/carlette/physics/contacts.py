"""Contacts between bodies: they are separated and exchange momentum. The numbers are ours."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from carlette.geometry import Floats, Vector
from carlette.physics.bodies import BodyTable
from carlette.physics.doors import OpenDoors
from carlette.physics.overlap import Boxes, Indices, boxes_of, near_pairs, overlaps

BOUNCE = 0.1
"""Coefficient of restitution."""
FRICTION = 0.4
"""Coefficient of friction between bodies."""
SLOP_M = 0.005
"""Penetration that is not corrected (m), so that resting bodies do not jitter."""
TOUCH_M = 0.001
"""Tolerance of a point on a box's edge (m)."""
STILL_MPS = 0.01
"""Speed below which a body counts as stationary (m/s)."""
RESTING_MPS = 1e-3
"""Approach speed below which two bodies rest on each other (m/s)."""
ROUNDS = 2
"""Number of separation rounds. Separating one pair may press another together; a second round settles a queue."""

Planar = tuple[float, float]


class Contact(NamedTuple):
    """Two bodies that hit each other in this tick."""

    first: int
    second: int
    """Rows in `BodyTable`."""
    impulse: Vector
    """Impulse on the second body (N·s, world frame); the first one gets the opposite."""


class ContactSide(NamedTuple):
    """One of the two bodies of a contact."""

    row: int
    inverse_mass: float
    """Inverse mass (1/kg); 0 if the body is immovable."""
    inverse_inertia: float
    """1/(kg·m²)."""
    arm: Planar
    """From the box's center to the point of contact."""


class Shapes(NamedTuple):
    """The boxes that can touch: one for each solid body, and one more for each open door."""

    rows: Indices
    """Row of the body that each box belongs to."""
    owner: Indices
    """Index of that body's own box."""
    center: Floats
    extent: Floats


def collide(bodies: BodyTable, doors: OpenDoors | None = None) -> list[Contact]:
    """Resolve all contacts between solid bodies and return those with an impulse."""
    shapes = _shapes(bodies, doors)
    rows = shapes.rows
    hits: dict[tuple[int, int], Vector] = {}
    for _ in range(ROUNDS):
        speed = np.abs(bodies.velocity[rows, :2]).max(axis=1, initial=0.0)
        moving = (speed > STILL_MPS) & (bodies.mass[rows] > 0)
        boxes = boxes_of(bodies, rows, (shapes.center, shapes.extent))
        first, second = near_pairs(boxes, moving)
        if doors is not None and len(doors):
            apart = shapes.owner[first] != shapes.owner[second]
            first, second = first[apart], second[apart]
        if not len(first):
            break
        found = overlaps(boxes, first, second)
        for i, j, normal, depth in zip(*(item.tolist() for item in found), strict=True):
            pair = (int(rows[i]), int(rows[j]))
            impulse = _resolve(bodies, boxes, shapes.owner, (i, j), pair, (normal[0], normal[1]), depth)
            if impulse is not None:
                hits[pair] = impulse.plus(hits.get(pair, Vector()))
        if not len(found.first):
            break
    return [Contact(*pair, impulse) for pair, impulse in hits.items()]


def _shapes(bodies: BodyTable, doors: OpenDoors | None) -> Shapes:
    rows: Indices = np.flatnonzero(bodies.solid)
    own = np.arange(len(rows))
    if doors is None or not len(doors):
        return Shapes(rows, own, bodies.center[rows], bodies.extent[rows])
    there = bodies.solid[doors.row]
    center, extent = doors.boxes(bodies)
    carriers = doors.row[there]
    return Shapes(
        np.concatenate([rows, carriers]),
        np.concatenate([own, np.searchsorted(rows, carriers)]),
        np.concatenate([bodies.center[rows], center[there]]),
        np.concatenate([bodies.extent[rows], extent[there]]),
    )


def _resolve(
    bodies: BodyTable,
    boxes: Boxes,
    owner: Indices,
    index: tuple[int, int],
    pair: tuple[int, int],
    away: Planar,
    depth: float,
) -> Vector | None:
    """Separate a pair and apply the impulse of the impact; None if they only rest on each other."""
    inverse = (_inverse_mass(bodies, pair[0]), _inverse_mass(bodies, pair[1]))
    total = inverse[0] + inverse[1]
    if total == 0.0:
        return None
    point = _touch_point(boxes, index)
    sides = []
    for sign, item, row, share in zip((-1.0, 1.0), index, pair, inverse, strict=True):
        shift = sign * share / total * max(depth - SLOP_M, 0.0)
        bodies.position[row, :2] += (shift * away[0], shift * away[1])
        x, y = boxes.center[owner[item]].tolist()
        half_x, half_y = boxes.half[owner[item]].tolist()
        inertia = 3.0 * share / (half_x**2 + half_y**2)
        sides.append(ContactSide(row, share, inertia, (point[0] - x, point[1] - y)))
    return _exchange(bodies, sides[0], sides[1], away)


def _exchange(bodies: BodyTable, first: ContactSide, second: ContactSide, away: Planar) -> Vector | None:
    """Apply the impulse that ends the approach, with friction along the touching faces."""
    item, other = _speed_at(bodies, first), _speed_at(bodies, second)
    closing = (other[0] - item[0], other[1] - item[1])
    normal_speed = _dot(closing, away)
    if normal_speed >= -RESTING_MPS:
        return None
    size = -(1.0 + BOUNCE) * normal_speed / _give(first, second, away)
    along = (-away[1], away[0])
    drag = -_dot(closing, along) / _give(first, second, along)
    drag = min(max(drag, -FRICTION * size), FRICTION * size)
    impulse = _passive((size * away[0] + drag * along[0], size * away[1] + drag * along[1]), first, second, closing)
    for sign, side in ((-1.0, first), (1.0, second)):
        push = sign * side.inverse_mass
        bodies.velocity[side.row, :2] += (push * impulse[0], push * impulse[1])
        bodies.angular[side.row, 2] += sign * math.degrees(side.inverse_inertia * _cross(side.arm, impulse))
    return Vector(impulse[0], impulse[1], 0.0)


def _passive(impulse: Planar, first: ContactSide, second: ContactSide, closing: Planar) -> Planar:
    """Return the impulse, reduced if its normal and friction parts together would add energy to the pair."""
    work = _dot(closing, impulse)
    size = math.hypot(*impulse)
    along = (impulse[0] / size, impulse[1] / size)
    gain = 0.5 * size * size * _give(first, second, along)
    # Half the step that would restore the initial energy dissipates the most.
    share = 1.0 if work + gain <= 0.0 else max(-work / (2.0 * gain), 0.0)
    return share * impulse[0], share * impulse[1]


def _give(first: ContactSide, second: ContactSide, along: Planar) -> float:
    """Return the change of a pair's relative speed along a direction per N·s."""
    turning = sum(side.inverse_inertia * _cross(side.arm, along) ** 2 for side in (first, second))
    return first.inverse_mass + second.inverse_mass + turning


def _speed_at(bodies: BodyTable, side: ContactSide) -> Planar:
    rate = math.radians(bodies.angular[side.row, 2])
    x, y, _ = bodies.velocity[side.row].tolist()
    return x - rate * side.arm[1], y + rate * side.arm[0]


def _inverse_mass(bodies: BodyTable, row: int) -> float:
    mass = float(bodies.mass[row])
    return 1.0 / mass if mass > 0 and bodies.simulated[row] else 0.0


def _touch_point(boxes: Boxes, index: tuple[int, int]) -> Planar:
    """Return the mean of those corners of each box that are within the other."""
    inside = [corner for a, b in (index, index[::-1]) for corner in _corners(boxes, a) if _within(boxes, b, corner)]
    points = inside or [tuple(boxes.center[item].tolist()) for item in index]
    return sum(point[0] for point in points) / len(points), sum(point[1] for point in points) / len(points)


def _corners(boxes: Boxes, index: int) -> list[Planar]:
    (x, y), (ax, ay), (half_x, half_y) = _shape(boxes, index)
    ends = [(a * half_x, b * half_y) for a in (-1, 1) for b in (-1, 1)]
    return [(x + a * ax - b * ay, y + a * ay + b * ax) for a, b in ends]


def _within(boxes: Boxes, index: int, point: Planar) -> bool:
    (x, y), ahead, (half_x, half_y) = _shape(boxes, index)
    gap = (point[0] - x, point[1] - y)
    return abs(_dot(gap, ahead)) <= half_x + TOUCH_M and abs(_cross(ahead, gap)) <= half_y + TOUCH_M


def _shape(boxes: Boxes, index: int) -> tuple[list[float], Planar, list[float]]:
    ahead = boxes.ahead[index].tolist()
    return boxes.center[index].tolist(), (ahead[0], ahead[1]), boxes.half[index].tolist()


def _dot(a: Planar, b: Planar) -> float:
    return a[0] * b[0] + a[1] * b[1]


def _cross(a: Planar, b: Planar) -> float:
    return a[0] * b[1] - a[1] * b[0]


def is_free(bodies: BodyTable, candidate: BodyTable, doors: OpenDoors | None = None) -> bool:
    """True if the one solid body of `candidate` would overlap no solid body and no open door."""
    shapes = _shapes(bodies, doors)
    there = boxes_of(bodies, shapes.rows, (shapes.center, shapes.extent))
    new = boxes_of(candidate, np.zeros(1, np.int64))
    both = Boxes(*(np.concatenate(pair) for pair in zip(new, there, strict=True)))
    moving = np.zeros(len(both.center), bool)
    moving[0] = True
    first, second = near_pairs(both, moving)
    return not len(overlaps(both, first, second).first)
