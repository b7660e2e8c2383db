"""Overlaps of boxes: oriented rectangles from above, and their heights."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats, columns
from carlette.physics.bodies import BodyTable

RESTING_MPS = 0.1
"""Speed below which an approach counts little against the depth in the choice of a contact's direction (m/s). Ours."""

Indices = NDArray[np.int64]


class Boxes(NamedTuple):
    """Upright boxes: arrays of planar centers, axes, half sizes and heights."""

    center: Floats
    ahead: Floats
    """Unit vector of the local x axis."""
    half: Floats
    bottom: Floats
    top: Floats
    velocity: Floats


class Overlap(NamedTuple):
    """Pairs that overlap; the normal points from the first to the second."""

    first: Indices
    second: Indices
    normal: Floats
    depth: Floats


def boxes_of(bodies: BodyTable, rows: Indices, shapes: tuple[Floats, Floats] | None = None) -> Boxes:
    """Return the bounding boxes of some bodies (or other `shapes` in their frames: centers and half sizes).

    Objects that pass under a body are excluded.
    """
    offset, extent = (bodies.center[rows], bodies.extent[rows]) if shapes is None else shapes
    yaw = np.radians(bodies.rotation[rows, 1])
    ahead = columns(np.cos(yaw), np.sin(yaw))
    position = bodies.position[rows]
    center = position[:, :2] + offset[:, :1] * ahead + offset[:, 1:2] * _left(ahead)
    middle = position[:, 2] + offset[:, 2]
    bottom = middle - extent[:, 2] + bodies.clearance[rows]
    return Boxes(center, ahead, extent[:, :2], bottom, middle + extent[:, 2], bodies.velocity[rows, :2])


def near_pairs(boxes: Boxes, moving: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Return the pairs whose circles and heights overlap and of which at least one moves; each pair once, i < j."""
    mover = np.flatnonzero(moving)
    radius = np.hypot(boxes.half[:, 0], boxes.half[:, 1])
    x, y = boxes.center[:, 0], boxes.center[:, 1]
    gap_x, gap_y = x[mover, None] - x, y[mover, None] - y
    reach = radius[mover, None] + radius
    close = gap_x * gap_x + gap_y * gap_y < reach * reach
    close &= boxes.bottom[mover, None] < boxes.top
    close &= boxes.bottom < boxes.top[mover, None]
    left, second = close.nonzero()
    first = mover[left]
    keep = (first < second) | ((first > second) & ~moving[second])
    first, second = first[keep], second[keep]
    return np.minimum(first, second), np.maximum(first, second)


def overlaps(boxes: Boxes, first: Indices, second: Indices) -> Overlap:
    """Return the pairs that overlap, with the direction in which they met and their depth in it.

    That is the direction in which the overlap began last, given the speed of approach. At rest, it is that of
    least depth.
    """
    a, b = boxes.ahead[first], boxes.ahead[second]
    axes = np.stack([a, _left(a), b, _left(b)], axis=1)
    gap = boxes.center[second] - boxes.center[first]
    along = (axes * gap[:, None, :]).sum(axis=2)
    depth = _reach(axes, a, boxes.half[first]) + _reach(axes, b, boxes.half[second]) - np.abs(along)
    hit = np.flatnonzero((depth > 0.0).all(axis=1))
    sign = np.where(along < 0.0, -1.0, 1.0)
    approach = boxes.velocity[first] - boxes.velocity[second]
    closing = (axes * approach[:, None, :]).sum(axis=2) * sign
    since = depth / (np.maximum(closing, 0.0) + RESTING_MPS)
    best = since[hit].argmin(axis=1)
    normal = axes[hit, best] * sign[hit, best][:, None]
    return Overlap(first[hit], second[hit], normal, depth[hit, best])


def _reach(axes: Floats, ahead: Floats, half: Floats) -> Floats:
    """Return half the length of each box's projection on each axis."""
    on_ahead = np.abs((axes * ahead[:, None, :]).sum(axis=2))
    on_left = np.abs((axes * _left(ahead)[:, None, :]).sum(axis=2))
    shadow: Floats = on_ahead * half[:, :1] + on_left * half[:, 1:]
    return shadow


def _left(ahead: Floats) -> Floats:
    return columns(-ahead[:, 1], ahead[:, 0])
