"""Computes the deceleration for predicted conflicts from several ego rollouts.

The driver handles stopped objects and lead vehicles in the path elsewhere. This module covers traffic that enters the
path from the side, and traffic into whose lane the path leads. The frame is CARLA's world frame (m, rad, s).
"""

from __future__ import annotations

import math

import numpy as np

from stucksolver.scene.boxes import separation
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import Array, Path, Projection
from stucksolver_carla.drivers.behavior.route_bodies import Flags, RouteObjects
from stucksolver_carla.drivers.behavior.swept_path import Hazard
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

STEP_S = 0.2
"""Step of the rollouts (s). Ours."""
HORIZON_S = 4.0
"""Horizon of the rollouts (s). Ours."""
BRAKING_MPS2 = (0.0, -1.0, -2.0, -3.5, -5.0, -8.0)
"""Accelerations of the rollouts besides the wanted one, gentle ones first (m/s²). Ours."""
CREEP_MPS = 1.0
"""Speed below which the ego stops firmly instead of creeping (m/s). Ours."""
HALT_MPS2 = 2.0
"""Minimum deceleration of such a stop (m/s²). Ours."""
CLEARANCE_M = 0.4
"""Clearance before and behind the ego's box (m). Ours."""
SIDE_CLEARANCE_M = 0.15
"""Clearance at the sides of the ego's box (m). Ours."""
FOLLOWER_S = 0.25
"""Time gap to a follower when the ego enters its lane (s). Ours."""
NEAR_M = 60.0
"""Maximum distance along the path of relevant traffic (m). Ours."""
_MAX_TURN_S = 2.0
"""Time after which a turn is predicted to end (s). Ours."""
_SMOOTHING_S = 0.2
"""Time constant of the smoothed turn rates (s). Ours."""
_DRIFT_S = 1.2
"""Time constant with which motion across the road fades (s). Ours."""
_ALIGNED_RAD = math.radians(35.0)
"""Maximum angle to the path of traffic that is predicted to follow the road (rad). Ours."""
_MOVING_MPS = 0.4
"""Speed above which an object moves (m/s). Ours."""
_ONCOMING_MPS = -1.0
"""Speed along the path below which an object is oncoming (m/s). Ours."""
_IN_LANE_M = 0.6
"""Maximum lateral offset of a lead vehicle, and lateral gap to the ego of a follower (m). Ours."""
PULL_OUT_RANGE_M = 2.2
"""Maximum lateral gap to the ego's path of a vehicle that pulls out (m). Ours."""
ACROSS_NOISE_MPS = 0.3
"""Error of a speed across the path from sensors (m/s): two standard deviations."""
STARTED_MPS = 1.0
"""Speed below which an object may only seem to move (m/s). Sensor mode only. Ours."""
SLOW_MPS = 6.0
"""Speed above which a vehicle at the roadside has not just started (m/s). Ours."""
PULL_OUT_SLOPE = 0.04
"""Minimum lateral motion toward the path of a vehicle that pulls out, per meter along it. Ours."""


def allowed_acceleration(
    path: Path,
    where: Projection,
    speed: float,
    wanted_mps2: float,
    bodies: RouteObjects,
    around: NearbyObjects,
    turning: Array,
    model: VehicleModel,
) -> float:
    """Return the highest acceleration up to the wanted one without a predicted conflict (m/s²).

    If all rollouts have conflicts, the result is the one with the latest conflict. An object counts if it is in
    conflict in both predictions: along the road, and with its present turn rate.

    Args:
        path: The ego's path.
        where: The ego's projection on it.
        speed: The ego's speed (m/s).
        wanted_mps2: The wanted acceleration (m/s²).
        bodies: The objects `around` in the frame of `path`, in the same order.
        around: The objects around the ego.
        turning: The turn rates of the objects' courses (rad/s).
        model: The ego's box.
    """
    is_relevant = _is_relevant(bodies, where, model)
    if not is_relevant.any():
        return wanted_mps2
    others, route_objects = around.part(is_relevant), bodies.part(is_relevant)
    t = np.arange(0.0, HORIZON_S + 1e-9, STEP_S)[1:]
    predictions = (_road_prediction(path, others, route_objects, t), _turn_prediction(others, turning[is_relevant], t))
    # An ego that hardly moves stops firmly. Creeping would slowly bring it into the path of the traffic.
    max_mps2 = min(wanted_mps2, -HALT_MPS2) if speed < CREEP_MPS else wanted_mps2
    candidates = [wanted_mps2] + [
        candidate for candidate in BRAKING_MPS2 if candidate < wanted_mps2 and candidate <= max_mps2
    ]
    half_length = others.half_length + FOLLOWER_S / 2.0 * np.hypot(others.vx, others.vy)
    best_mps2, latest_s = candidates[-1], -1.0
    for acceleration in candidates:
        s, v = _rollout(where.s, speed, acceleration, t)
        ex, ey, eyaw = path.at(s)
        offset = where.lateral * np.exp(-(s - where.s) / max(4.0, speed))
        ex, ey = ex - offset * np.sin(eyaw), ey + offset * np.cos(eyaw)
        ego = (ex[:, None], ey[:, None], eyaw[:, None])
        size = (model.half_length + CLEARANCE_M, model.half_width + SIDE_CLEARANCE_M)
        overlaps = [
            separation(ego, size, prediction, (half_length, others.half_width)) <= 0.0 for prediction in predictions
        ]
        # A stopped ego is not in conflict, because a vehicle that would hit it can stop.
        is_conflict = overlaps[0] & (v > _MOVING_MPS)[:, None] & overlaps[1].any(axis=0)
        touched_steps = is_conflict.any(axis=1)
        if not touched_steps.any():
            return acceleration
        first_s = float(t[int(np.argmax(touched_steps))])
        if first_s > latest_s + STEP_S / 2.0:
            best_mps2, latest_s = acceleration, first_s
    return best_mps2


def vehicles_pulling_out(
    bodies: RouteObjects, where: Projection, model: VehicleModel, passing_mps: float = 0.0
) -> list[Hazard]:
    """Return vehicles ahead next to the ego's path that are pulling out into it, as hazards in the path.

    With the ego's speed `passing_mps` (m/s), vehicles do not count if the ego passes them before. With sensor-based
    perception, vehicles alongside sometimes seem to drift toward the ego, and hard braking for them would be worse.
    """
    approach_mps = -np.sign(bodies.d - where.lateral) * bodies.vd
    is_approaching = approach_mps > PULL_OUT_SLOPE * np.abs(bodies.vs)
    if passing_mps > 0.0:
        side_gap_m = np.abs(bodies.d - where.lateral) - bodies.aside - model.half_width
        remaining_m = bodies.s + bodies.along - where.s + model.half_length
        sure_approach_mps = np.maximum(approach_mps - ACROSS_NOISE_MPS, 0.0)
        is_approaching &= remaining_m * sure_approach_mps >= side_gap_m * np.maximum(passing_mps - bodies.vs, 0.0)
    return _adjacent_hazards(bodies, where, model, (bodies.speed > _MOVING_MPS) & is_approaching)


def slow_adjacent_vehicles(bodies: RouteObjects, where: Projection, model: VehicleModel) -> list[Hazard]:
    """Return slow vehicles ahead next to the ego's path, as hazards in the path.

    A slow vehicle at the roadside has started and will pull out. Sensors detect a start after about 0.8 s, and a turn
    even later.
    """
    return _adjacent_hazards(bodies, where, model, (bodies.speed > STARTED_MPS) & (bodies.vs < SLOW_MPS))


def _adjacent_hazards(bodies: RouteObjects, where: Projection, model: VehicleModel, selected: Flags) -> list[Hazard]:
    """Return the selected vehicles ahead next to the path that drive in its direction, as hazards in the path."""
    side_gap_m = np.abs(bodies.d - where.lateral) - bodies.aside - model.half_width
    gap = bodies.s - bodies.along - where.s - model.half_length
    is_adjacent = (
        (side_gap_m > 0.0) & (side_gap_m < PULL_OUT_RANGE_M) & (gap > -1.0) & (gap < NEAR_M) & ~bodies.is_walker
    )
    indices = np.flatnonzero(is_adjacent & selected & (bodies.vs > 0.0)).tolist()
    return [Hazard(int(bodies.actor_id[k]), max(float(gap[k]), 0.0), float(bodies.vs[k]), False) for k in indices]


def _is_relevant(bodies: RouteObjects, where: Projection, model: VehicleModel) -> Flags:
    """Return True for near moving objects that are not oncoming, and neither follow nor lead the ego in its lane."""
    along = bodies.s - where.s
    is_near = (np.abs(along) < NEAR_M) & (bodies.speed > _MOVING_MPS) & ~bodies.is_walker
    is_oncoming = (bodies.vs < _ONCOMING_MPS) & (np.abs(bodies.vd) < -bodies.vs)
    is_in_lane = np.abs(bodies.d - where.lateral) < model.half_width + _IN_LANE_M
    is_behind = (along < 0.0) & is_in_lane
    is_leading = (along > 0.0) & (np.abs(bodies.d) < _IN_LANE_M) & (np.abs(bodies.vd) < 0.3)
    return np.asarray(is_near & ~is_oncoming & ~is_behind & ~is_leading)


def _road_prediction(
    path: Path, others: NearbyObjects, route_objects: RouteObjects, t: Array
) -> tuple[Array, Array, Array]:
    """Return poses (times x objects): along the path for objects that drive along it, straight for all others."""
    times = t[:, None]
    x, y = others.x + others.vx * times, others.y + others.vy * times
    is_aligned = np.abs(np.arctan2(route_objects.vd, route_objects.vs)) < _ALIGNED_RAD
    turn_rad = np.zeros_like(x)
    if is_aligned.any():
        along = route_objects.part(is_aligned)
        s = along.s + along.vs * times
        d = along.d + along.vd * _DRIFT_S * (1.0 - np.exp(-times / _DRIFT_S))
        line_x, line_y, line_yaw = path.at(s)
        x[:, is_aligned], y[:, is_aligned] = line_x - d * np.sin(line_yaw), line_y + d * np.cos(line_yaw)
        turn_rad[:, is_aligned] = line_yaw - path.at(along.s)[2]
    return x, y, others.yaw + turn_rad


def _turn_prediction(others: NearbyObjects, rate: Array, t: Array) -> tuple[Array, Array, Array]:
    """Return poses (times x objects) with constant turn rate and speed."""
    turn_rad = rate * np.minimum(t, _MAX_TURN_S)[:, None]
    course = np.arctan2(others.vy, others.vx) + turn_rad
    step = np.hypot(others.vx, others.vy) * STEP_S
    x = others.x + np.cumsum(step * np.cos(course), axis=0)
    y = others.y + np.cumsum(step * np.sin(course), axis=0)
    return x, y, others.yaw + turn_rad


class TurnRates:
    """The turn rate of each object's course, measured from tick to tick."""

    def __init__(self) -> None:
        self._courses: dict[int, tuple[float, float]] = {}
        """Course (rad) and smoothed rate (rad/s)."""

    def observe(self, around: NearbyObjects, dt_s: float) -> Array:
        """Return the turn rates of the objects, in their order (rad/s); 0 for stopped and new ones."""
        speed = np.hypot(around.vx, around.vy).tolist()
        course = np.arctan2(around.vy, around.vx).tolist()
        route_objects = {}
        for candidate, v, course_now in zip(around.actor_id, speed, course, strict=True):
            if v > _MOVING_MPS:
                course_before, rate = self._courses.get(candidate, (course_now, 0.0))
                measured = math.remainder(course_now - course_before, math.tau) / dt_s
                route_objects[candidate] = (course_now, rate + min(dt_s / _SMOOTHING_S, 1.0) * (measured - rate))
        self._courses = route_objects
        return np.array(
            [route_objects[candidate][1] if candidate in route_objects else 0.0 for candidate in around.actor_id],
            dtype=np.float64,
        )


def _rollout(s: float, speed: float, acceleration: float, t: Array) -> tuple[Array, Array]:
    v = np.maximum(speed + acceleration * t, 0.0)
    steps = (np.concatenate([[speed], v[:-1]]) + v) / 2.0 * STEP_S
    return s + np.cumsum(steps), v
