"""How hard to brake for traffic that will be where the ego will be: several drives are rolled out against it.

Standing bodies and leaders in the path are the driver's own concern. Here it is traffic that enters the path from the
side, and traffic into whose lane the path leads. CARLA's world frame, meters, radians, seconds.
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
HORIZON_S = 4.0
BRAKING_MPS2 = (0.0, -1.0, -2.0, -3.5, -5.0, -8.0)
"""Accelerations tried besides the wanted one, gentle ones first."""
CREEPS_MPS = 1.0
HALTS_MPS2 = 2.0
CLEARANCE_M = 0.4
"""Clearance kept before and behind the ego's body (m)."""
BESIDE_M = 0.15
"""Clearance kept on either side of it (m)."""
AFTER_S = 0.25
"""Seconds of the follower's drive kept between it and the ego, if the ego moves in."""
NEAR_M = 60.0
_TURNS_S = 2.0
"""Nobody keeps turning for longer than this."""
_SMOOTHED_S = 0.2
_DRIFTS_S = 1.2
"""Sideways motion across the road fades with this time constant."""
_ALIGNED_RAD = math.radians(35.0)
_MOVES_MPS = 0.4
_COMES_MPS = -1.0
_IN_LANE_M = 0.6
ENTERS_FROM_M = 2.2
"""Vehicles that pull out are looked for this far beside the ego's way."""
ACROSS_NOISE_MPS = 0.3
"""By sensors, a speed across the way is off by up to this (m/s): two standard deviations."""
SETS_OFF_MPS = 1.0
"""By sensors, what is slower may only seem to move (m/s)."""
SLOW_MPS = 6.0
"""Whoever is faster at the roadside has not just set off (m/s)."""
ENTERS_SLOPE = 0.04
"""Meters toward the ego's way per meter along it at which a vehicle is pulling out."""


def allowed_acceleration(
    path: Path,
    where: Projection,
    speed: float,
    wished: float,
    bodies: RouteObjects,
    around: NearbyObjects,
    turning: Array,
    model: VehicleModel,
) -> float:
    """Return the highest acceleration up to `wished` with which the ego meets nobody; the hardest braking if all meet
    someone.

    `bodies` are those `around`, in the same order, seen from `path`; `speed` is the ego's; `turning` has the turn rates
    of the others' courses (rad/s). It brakes for those it meets in both predictions: as the road leads, and as they
    turn.
    """
    who = _concern_us(bodies, where, model)
    if not who.any():
        return wished
    others, seen = around.part(who), bodies.part(who)
    t = np.arange(0.0, HORIZON_S + 1e-9, STEP_S)[1:]
    forecasts = (_along_the_road(path, others, seen, t), _as_they_turn(others, turning[who], t))
    # An ego that hardly moves stops: creeping on would slowly bring it into the others' way.
    gentlest = min(wished, -HALTS_MPS2) if speed < CREEPS_MPS else wished
    tried = [wished] + [item for item in BRAKING_MPS2 if item < wished and item <= gentlest]
    half_length = others.half_length + AFTER_S / 2.0 * np.hypot(others.vx, others.vy)
    best, latest = tried[-1], -1.0
    for acceleration in tried:
        s, v = _driven(where.s, speed, acceleration, t)
        ex, ey, eyaw = path.at(s)
        offset = where.lateral * np.exp(-(s - where.s) / max(4.0, speed))
        ex, ey = ex - offset * np.sin(eyaw), ey + offset * np.cos(eyaw)
        ego = (ex[:, None], ey[:, None], eyaw[:, None])
        size = (model.half_length + CLEARANCE_M, model.half_width + BESIDE_M)
        met = [separation(ego, size, forecast, (half_length, others.half_width)) <= 0.0 for forecast in forecasts]
        # A vehicle that runs into a standing one could have stopped.
        both = met[0] & (v > _MOVES_MPS)[:, None] & met[1].any(axis=0)
        touches = both.any(axis=1)
        if not touches.any():
            return acceleration
        first = float(t[int(np.argmax(touches))])
        if first > latest + STEP_S / 2.0:
            best, latest = acceleration, first
    return best


def entering(bodies: RouteObjects, where: Projection, model: VehicleModel, passing_mps: float = 0.0) -> list[Hazard]:
    """Return vehicles ahead beside the ego's way that pull out into it, as if they were in it already.

    `passing_mps`: the ego's speed (m/s), if those do not count whom it will have passed by then. By sensors, whoever is
    passed seems to drift toward the ego now and then, and to brake hard for them would be worse.
    """
    nears_mps = -np.sign(bodies.d - where.lateral) * bodies.vd
    towards = nears_mps > ENTERS_SLOPE * np.abs(bodies.vs)
    if passing_mps > 0.0:
        free_m = np.abs(bodies.d - where.lateral) - bodies.aside - model.half_width
        left_m = bodies.s + bodies.along - where.s + model.half_length
        surely_mps = np.maximum(nears_mps - ACROSS_NOISE_MPS, 0.0)
        towards &= left_m * surely_mps >= free_m * np.maximum(passing_mps - bodies.vs, 0.0)
    return _beside(bodies, where, model, (bodies.speed > _MOVES_MPS) & towards)


def slow_adjacent_vehicles(bodies: RouteObjects, where: Projection, model: VehicleModel) -> list[Hazard]:
    """Return vehicles ahead beside the ego's way that drive slowly, as if they were in it already.

    If they are at the roadside they have set off and will pull out. Sensors notice a start after some 0.8 s, and a turn
    later still.
    """
    return _beside(bodies, where, model, (bodies.speed > SETS_OFF_MPS) & (bodies.vs < SLOW_MPS))


def _beside(bodies: RouteObjects, where: Projection, model: VehicleModel, which: Flags) -> list[Hazard]:
    """Return those of the vehicles ahead beside the ego's way that drive in its direction, as hazards in it."""
    free = np.abs(bodies.d - where.lateral) - bodies.aside - model.half_width
    gap = bodies.s - bodies.along - where.s - model.half_length
    beside = (free > 0.0) & (free < ENTERS_FROM_M) & (gap > -1.0) & (gap < NEAR_M) & ~bodies.is_walker
    found = np.flatnonzero(beside & which & (bodies.vs > 0.0)).tolist()
    return [Hazard(int(bodies.actor_id[k]), max(float(gap[k]), 0.0), float(bodies.vs[k]), False) for k in found]


def _concern_us(bodies: RouteObjects, where: Projection, model: VehicleModel) -> Flags:
    """True for those that move, are near, do not come toward us, and neither follow nor lead us in the lane."""
    along = bodies.s - where.s
    near = (np.abs(along) < NEAR_M) & (bodies.speed > _MOVES_MPS) & ~bodies.is_walker
    comes = (bodies.vs < _COMES_MPS) & (np.abs(bodies.vd) < -bodies.vs)
    in_lane = np.abs(bodies.d - where.lateral) < model.half_width + _IN_LANE_M
    behind = (along < 0.0) & in_lane
    leads = (along > 0.0) & (np.abs(bodies.d) < _IN_LANE_M) & (np.abs(bodies.vd) < 0.3)
    return np.asarray(near & ~comes & ~behind & ~leads)


def _along_the_road(path: Path, others: NearbyObjects, seen: RouteObjects, t: Array) -> tuple[Array, Array, Array]:
    """Poses (times x bodies): along the ego's way if they drive along it, else straight on."""
    gone = t[:, None]
    x, y = others.x + others.vx * gone, others.y + others.vy * gone
    aligned = np.abs(np.arctan2(seen.vd, seen.vs)) < _ALIGNED_RAD
    turned = np.zeros_like(x)
    if aligned.any():
        along = seen.part(aligned)
        s = along.s + along.vs * gone
        d = along.d + along.vd * _DRIFTS_S * (1.0 - np.exp(-gone / _DRIFTS_S))
        line_x, line_y, line_yaw = path.at(s)
        x[:, aligned], y[:, aligned] = line_x - d * np.sin(line_yaw), line_y + d * np.cos(line_yaw)
        turned[:, aligned] = line_yaw - path.at(along.s)[2]
    return x, y, others.yaw + turned


def _as_they_turn(others: NearbyObjects, rate: Array, t: Array) -> tuple[Array, Array, Array]:
    """Poses (times x bodies) with constant turn rate and velocity."""
    turned = rate * np.minimum(t, _TURNS_S)[:, None]
    course = np.arctan2(others.vy, others.vx) + turned
    step = np.hypot(others.vx, others.vy) * STEP_S
    x = others.x + np.cumsum(step * np.cos(course), axis=0)
    y = others.y + np.cumsum(step * np.sin(course), axis=0)
    return x, y, others.yaw + turned


class TurnRates:
    """The turn rate of each body's course, measured from tick to tick."""

    def __init__(self) -> None:
        self._seen: dict[int, tuple[float, float]] = {}
        """Course (rad) and smoothed rate (rad/s)."""

    def see(self, around: NearbyObjects, dt_s: float) -> Array:
        """Return the rates of the bodies around, in their order (rad/s); 0 for standing and new ones."""
        speed = np.hypot(around.vx, around.vy).tolist()
        course = np.arctan2(around.vy, around.vx).tolist()
        seen = {}
        for item, v, now in zip(around.actor_id, speed, course, strict=True):
            if v > _MOVES_MPS:
                before, rate = self._seen.get(item, (now, 0.0))
                measured = math.remainder(now - before, math.tau) / dt_s
                seen[item] = (now, rate + min(dt_s / _SMOOTHED_S, 1.0) * (measured - rate))
        self._seen = seen
        return np.array([seen[item][1] if item in seen else 0.0 for item in around.actor_id], dtype=np.float64)


def _driven(s: float, speed: float, acceleration: float, t: Array) -> tuple[Array, Array]:
    v = np.maximum(speed + acceleration * t, 0.0)
    steps = (np.concatenate([[speed], v[:-1]]) + v) / 2.0 * STEP_S
    return s + np.cumsum(steps), v
