"""Finds objects in the swept path of the ego.

`BehaviorAgent` measures between centers and uses the lanes of vehicles. In this module the gap is the travel until the
bumper touches, and an object next to the path is no hazard at any distance.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.boxes import axis_gaps
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import Array, Path, PlanarPose, Projection
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

STEP_M = 0.5
"""Travel between two poses of the sweep (m). Ours."""
_CLEAR_BELOW_M = 1.0
"""Objects that end this far below the path are on another level (m). Ours."""
_CLEAR_ABOVE_M = 2.3
"""Objects that start this far above the path are on another level (m). Ours."""
_TOUCHING_TRAVEL_M = 1.0
"""Travel after which an object that touches the ego now must be clear (m). Ours."""
WALKER_MARGIN_M = 0.5
"""Clearance to pedestrians at the ego's sides (m). Ours."""
_NOSE_M = 0.7
"""Maximum distance behind the ego's front at which its corner could hit a pedestrian alongside (m). Ours.

This happens if the pedestrian is a little nearer than measured. Sensor mode only."""
_WALKER_HORIZON_S = 2.5
"""Time for which walking pedestrians are predicted (s). Ours."""
_WALKER_MIN_SPEED_MPS = 0.3
"""Minimum speed of a walking pedestrian (m/s). Ours."""
_WALKER_STEPS = 5
"""Number of predicted positions per pedestrian. Ours."""

Flags = NDArray[np.bool_]


class Hazard(NamedTuple):
    """An object in the path."""

    actor_id: int
    gap: float
    """Travel until the ego's box would touch the object (m)."""
    speed: float
    """Speed of the object along the path (m/s), at least 0."""
    is_walker: bool


class SweptPath(NamedTuple):
    """Poses of the ego's box along the path ahead (m, rad), the present one first."""

    travel: Array
    x: Array
    y: Array
    z: Array
    yaw: Array


def sweep(
    path: Path, where: Projection, pose: PlanarPose, model: VehicleModel, reach: float, length: float, side: int = 1
) -> SweptPath:
    """Return the box's poses over the next `length` meters. The present offset fades over about `reach` meters.

    `side` is 1 for driving ahead and -1 for backing up, with the flipped `pose`.
    """
    end = min(where.s + length, max(path.length, where.s + STEP_M))
    travel = np.arange(0.0, end - where.s + STEP_M, STEP_M)
    s = where.s + travel
    x, y, yaw = path.at(s)
    offset = where.lateral * (1.0 + travel / reach) * np.exp(-travel / reach)
    x, y = x - offset * np.sin(yaw), y + offset * np.cos(yaw)
    # In a bend, the direction of the box differs from the motion of its center by the slip.
    curvature = np.interp(s, path.s, path.curvature)
    slip = side * np.arcsin(np.clip(model.rear_axle * curvature, -0.8, 0.8))
    yaw = yaw - slip + (where.heading + slip[0]) * np.exp(-travel / reach)
    x[0], y[0], yaw[0] = pose
    return SweptPath(travel, x, y, np.interp(s, path.s, path.z), yaw)


def nearest_hazards(
    swept: SweptPath,
    around: NearbyObjects,
    model: VehicleModel,
    margin: float,
    walker_margin: float,
    doubt_m: float = 0.0,
) -> list[Hazard]:
    """Return all objects in the swept path, nearest first, with `margin` meters at the ego's sides.

    `doubt_m` is the maximum error of the objects' positions (m); 0 for ground truth.
    """
    if len(around) == 0:
        return []
    bodies = _with_predicted_walkers(around)
    margins = np.where(bodies.is_walker, walker_margin, margin)
    lon, touch, hit = _overlaps(swept, bodies, model, margins)
    # An object already within the margin is alongside, so only contact counts. An object in contact that is clear after
    # some travel does not count either. Otherwise the ego could never drive away from it.
    hit = np.where(hit[0], touch, hit)
    is_leaving = hit[0] & ~hit[swept.travel >= _TOUCHING_TRAVEL_M].any(axis=0)
    if doubt_m > 0.0:
        at_nose = _walkers_at_nose(swept, bodies, model, doubt_m)
        hit[0] |= at_nose
        is_leaving &= ~at_nose
    hit = hit & _at_height(swept, bodies) & ~is_leaving
    hazards = [_hazard(swept, bodies, int(j), lon, hit) for j in np.flatnonzero(hit.any(axis=0))]
    return sorted(hazards, key=lambda hazard: hazard.gap)


def _overlaps(
    swept: SweptPath, bodies: NearbyObjects, model: VehicleModel, margins: Array
) -> tuple[Array, Flags, Flags]:
    """Return, per pose (rows) and object (columns): free length ahead, overlap, and overlap with the margin."""
    ego = (swept.x[:, None], swept.y[:, None], swept.yaw[:, None])
    half = (bodies.half_length, bodies.half_width)
    gaps = axis_gaps(ego, (model.half_length, model.half_width), (bodies.x, bodies.y, bodies.yaw), half)
    return gaps.along_a, gaps.separation <= 0.0, gaps.with_a_wider(margins).separation <= 0.0


def _walkers_at_nose(swept: SweptPath, bodies: NearbyObjects, model: VehicleModel, doubt_m: float) -> Flags:
    """Return (objects,): True for pedestrians that may be in front of the ego's corner."""
    margins = np.where(bodies.is_walker, doubt_m, 0.0)
    present = SweptPath(*(column[:1] for column in swept))
    along, _, is_near = _overlaps(present, bodies, model, margins)
    yaw = float(present.yaw[0])
    is_ahead = (bodies.x - present.x[0]) * math.cos(yaw) + (bodies.y - present.y[0]) * math.sin(yaw) > 0.0
    return np.asarray(bodies.is_walker & is_near[0] & is_ahead & (along[0] > -_NOSE_M))


def _at_height(swept: SweptPath, bodies: NearbyObjects) -> Flags:
    """Return (poses, objects): True if the object is on the path's level, not on a road below or a bridge above."""
    road = swept.z[:, None]
    return np.asarray((bodies.top > road - _CLEAR_BELOW_M) & (bodies.bottom < road + _CLEAR_ABOVE_M))


def _hazard(swept: SweptPath, bodies: NearbyObjects, j: int, free_ahead: Array, hit: Flags) -> Hazard:
    k = int(np.argmax(hit[:, j]))
    gap = 0.0
    if k > 0:
        # The contact is between two poses. The gap is the travel to the earlier one plus the free length ahead of it.
        travel_before = float(swept.travel[k - 1])
        gap = min(travel_before + max(float(free_ahead[k - 1, j]), 0.0), float(swept.travel[k]))
    yaw = float(swept.yaw[k])
    speed = float(bodies.vx[j]) * math.cos(yaw) + float(bodies.vy[j]) * math.sin(yaw)
    return Hazard(bodies.actor_id[j], gap, max(speed, 0.0), bool(bodies.is_walker[j]))


def _with_predicted_walkers(around: NearbyObjects) -> NearbyObjects:
    """Return the objects with walking pedestrians also at their predicted positions, as if they were already there."""
    moving = around.is_walker & (np.hypot(around.vx, around.vy) > _WALKER_MIN_SPEED_MPS)
    if not moving.any():
        return around
    index = np.concatenate([np.arange(len(around)), np.tile(np.flatnonzero(moving), _WALKER_STEPS)])
    times = np.linspace(_WALKER_HORIZON_S / _WALKER_STEPS, _WALKER_HORIZON_S, _WALKER_STEPS)
    is_ahead = np.concatenate([np.zeros(len(around)), np.repeat(times, int(moving.sum()))])
    return NearbyObjects(
        actor_id=tuple(around.actor_id[i] for i in index),
        is_walker=around.is_walker[index],
        x=around.x[index] + around.vx[index] * is_ahead,
        y=around.y[index] + around.vy[index] * is_ahead,
        yaw=around.yaw[index],
        half_length=around.half_length[index],
        half_width=around.half_width[index],
        bottom=around.bottom[index],
        top=around.top[index],
        vx=around.vx[index],
        vy=around.vy[index],
    )
