"""The speed limit of each vehicle: that of the last sign whose box it touched."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats
from carlette.opendrive.speed_limit_boxes import SpeedBoxes
from carlette.physics.bodies import BodyTable
from carlette.physics.vehicle_dynamics import Vehicles

NEAR_M = 15.0
"""Distance in x or y beyond which boxes are not examined (m). Ours; no vehicle is that long."""


def pass_signs(bodies: BodyTable, fleet: Vehicles, boxes: SpeedBoxes) -> None:
    """Give each vehicle that touches a sign's box that sign's limit, and write all limits into the records."""
    rows = fleet.row
    if len(boxes) and len(rows):
        gap = bodies.position[rows, None, :2] - boxes.center[:, :2]
        car, box = (np.abs(gap).max(axis=2) < NEAR_M).nonzero()
        if len(car):
            touching = _touch(bodies, rows[car], boxes, box)
            fleet.limit_kmh[car[touching]] = boxes.kmh[box[touching]]
    bodies.record["speed_limit"][rows] = fleet.limit_kmh


def _touch(bodies: BodyTable, row: NDArray[np.int64], boxes: SpeedBoxes, box: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which pairs of a vehicle's row and a box overlap in the plane: no axis of either separates them."""
    yaw = np.radians(bodies.rotation[row, 1])
    along = _unit(yaw)
    center, extent = bodies.center[row], bodies.extent[row]
    middle = bodies.position[row, :2] + center[:, :1] * along + center[:, 1:2] * _right(along)
    offset = middle - boxes.center[box, :2]
    turn = yaw - boxes.yaw[box]
    cos, sin = np.abs(np.cos(turn)), np.abs(np.sin(turn))
    half = boxes.half[box]
    height = bodies.position[row, 2] + center[:, 2] - boxes.center[box, 2]
    touching: NDArray[np.bool_] = np.abs(height) <= extent[:, 2] + half
    lane = _unit(boxes.yaw[box])
    for axis, own, other in (
        (along, extent[:, 0], half * (cos + sin)),
        (_right(along), extent[:, 1], half * (cos + sin)),
        (lane, half, extent[:, 0] * cos + extent[:, 1] * sin),
        (_right(lane), half, extent[:, 0] * sin + extent[:, 1] * cos),
    ):
        touching &= np.abs((offset * axis).sum(axis=1)) <= own + other
    return touching


def _unit(yaw: Floats) -> Floats:
    return np.stack((np.cos(yaw), np.sin(yaw)), axis=1)


def _right(along: Floats) -> Floats:
    """Return the axis a quarter turn clockwise from `along` (CARLA's y points right)."""
    return np.stack((-along[:, 1], along[:, 0]), axis=1)
