"""Finds what lies in the way: the ego's body swept along its path, tested against the boxes around it.

`BehaviorAgent` measures between centers and asks which lane a vehicle is on. Here the gap is the travel left until the
bumper touches, and a body beside the path is no hazard however near.
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
_CLEAR_BELOW_M = 1.0
_CLEAR_ABOVE_M = 2.3
_TOUCHING_TRAVEL_M = 1.0
WALKER_MARGIN_M = 0.5
_NOSE_M = 0.7
"""Someone beside the ego, no further behind its front than this, is run into by its corner if they are a little nearer
than they seem.
"""
_WALKER_HORIZON_S = 2.5
_WALKER_MIN_SPEED_MPS = 0.3
_WALKER_STEPS = 5

Flags = NDArray[np.bool_]


class Hazard(NamedTuple):
    """A body in the path."""

    actor_id: int
    gap: float
    """Travel left until the ego's body would touch it (m)."""
    speed: float
    """Its speed along the path (m/s), never below 0."""
    is_walker: bool


class SweptPath(NamedTuple):
    """Poses of the ego's body along the path ahead, the present one first; meters and radians."""

    travel: Array
    x: Array
    y: Array
    z: Array
    yaw: Array


def sweep(
    path: Path, where: Projection, pose: PlanarPose, model: VehicleModel, reach: float, length: float, side: int = 1
) -> SweptPath:
    """Return the body's poses over the next `length` meters; the present offset fades over about `reach`.

    `side` is 1 for driving ahead and -1 for backing up; `pose` is then the flipped one.
    """
    end = min(where.s + length, max(path.length, where.s + STEP_M))
    travel = np.arange(0.0, end - where.s + STEP_M, STEP_M)
    s = where.s + travel
    x, y, yaw = path.at(s)
    offset = where.lateral * (1.0 + travel / reach) * np.exp(-travel / reach)
    x, y = x - offset * np.sin(yaw), y + offset * np.cos(yaw)
    # In a bend the body's center does not move in the direction in which the body points.
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
    """Return every body that the sweep meets, nearest first, with `margin` meters beside the ego.

    `doubt_m` is how far bodies may be from where they are taken to be (m).
    """
    if len(around) == 0:
        return []
    bodies = _with_predicted_walkers(around)
    margins = np.where(bodies.is_walker, walker_margin, margin)
    lon, touch, hit = _overlaps(swept, bodies, model, margins)
    # A body already within the margin is beside us: only touching it counts. A body that touches now and is left behind
    # by driving on does not count either, or the ego could never get away from it.
    hit = np.where(hit[0], touch, hit)
    leaving = hit[0] & ~hit[swept.travel >= _TOUCHING_TRAVEL_M].any(axis=0)
    if doubt_m > 0.0:
        at_nose = _walkers_at_nose(swept, bodies, model, doubt_m)
        hit[0] |= at_nose
        leaving &= ~at_nose
    hit = hit & _at_height(swept, bodies) & ~leaving
    found = [_hazard(swept, bodies, int(j), lon, hit) for j in np.flatnonzero(hit.any(axis=0))]
    return sorted(found, key=lambda hazard: hazard.gap)


def _overlaps(
    swept: SweptPath, bodies: NearbyObjects, model: VehicleModel, margins: Array
) -> tuple[Array, Flags, Flags]:
    """Return, per pose (rows) and body (columns): free length ahead, overlap, and overlap with the margin."""
    ego = (swept.x[:, None], swept.y[:, None], swept.yaw[:, None])
    half = (bodies.half_length, bodies.half_width)
    gaps = axis_gaps(ego, (model.half_length, model.half_width), (bodies.x, bodies.y, bodies.yaw), half)
    return gaps.along_a, gaps.separation <= 0.0, gaps.with_a_wider(margins).separation <= 0.0


def _walkers_at_nose(swept: SweptPath, bodies: NearbyObjects, model: VehicleModel, doubt_m: float) -> Flags:
    """(bodies,): walkers who may be in front of the ego's corner."""
    margins = np.where(bodies.is_walker, doubt_m, 0.0)
    now = SweptPath(*(column[:1] for column in swept))
    along, _, near = _overlaps(now, bodies, model, margins)
    yaw = float(now.yaw[0])
    ahead = (bodies.x - now.x[0]) * math.cos(yaw) + (bodies.y - now.y[0]) * math.sin(yaw) > 0.0
    return np.asarray(bodies.is_walker & near[0] & ahead & (along[0] > -_NOSE_M))


def _at_height(swept: SweptPath, bodies: NearbyObjects) -> Flags:
    """True if the body is neither on a road below nor a bridge above."""
    road = swept.z[:, None]
    return np.asarray((bodies.top > road - _CLEAR_BELOW_M) & (bodies.bottom < road + _CLEAR_ABOVE_M))


def _hazard(swept: SweptPath, bodies: NearbyObjects, j: int, free_ahead: Array, hit: Flags) -> Hazard:
    k = int(np.argmax(hit[:, j]))
    gap = 0.0
    if k > 0:
        # The contact is between two poses; the earlier one knows the free length ahead of it.
        before = float(swept.travel[k - 1])
        gap = min(before + max(float(free_ahead[k - 1, j]), 0.0), float(swept.travel[k]))
    yaw = float(swept.yaw[k])
    speed = float(bodies.vx[j]) * math.cos(yaw) + float(bodies.vy[j]) * math.sin(yaw)
    return Hazard(bodies.actor_id[j], gap, max(speed, 0.0), bool(bodies.is_walker[j]))


def _with_predicted_walkers(around: NearbyObjects) -> NearbyObjects:
    """Add moving walkers at the places they will reach soon: a walker about to step in counts as being there."""
    moving = around.is_walker & (np.hypot(around.vx, around.vy) > _WALKER_MIN_SPEED_MPS)
    if not moving.any():
        return around
    index = np.concatenate([np.arange(len(around)), np.tile(np.flatnonzero(moving), _WALKER_STEPS)])
    times = np.linspace(_WALKER_HORIZON_S / _WALKER_STEPS, _WALKER_HORIZON_S, _WALKER_STEPS)
    ahead = np.concatenate([np.zeros(len(around)), np.repeat(times, int(moving.sum()))])
    return NearbyObjects(
        actor_id=tuple(around.actor_id[i] for i in index),
        is_walker=around.is_walker[index],
        x=around.x[index] + around.vx[index] * ahead,
        y=around.y[index] + around.vy[index] * ahead,
        yaw=around.yaw[index],
        half_length=around.half_length[index],
        half_width=around.half_width[index],
        bottom=around.bottom[index],
        top=around.top[index],
        vx=around.vx[index],
        vy=around.vy[index],
    )
