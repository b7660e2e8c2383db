"""Decides whether the stack may resume driving where a plan or a stop has ended, and watches it afterward."""

from __future__ import annotations

import math

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.policy import GuardPolicy, HandBackPolicy
from stucksolver.guard.prediction import stationary_gaps
from stucksolver.guard.verdict import RejectReason
from stucksolver.plan.frenet_path import STEP_M, FrenetPath, lateral, shortest_shift
from stucksolver.scene.boxes import separation
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Array, Mask
from stucksolver.scene.frenet_scene import MOVING_MPS, FrenetScene
from stucksolver.scene.objects import PASSABLE_KINDS

SAMPLES = 16
"""Number of samples of the arc back; finer than the stations of a path."""


def clear_to_hand_back(view: FrenetScene, policy: GuardPolicy, curvature_per_m: float = 0.0) -> bool:
    """True if the driver's own next second is clear, and for an ego out of its lane also the tightest path back.

    Driving stacks look along their lane. If the vehicle is askew beside an obstacle, a stack may miss the obstacle and
    steer into it, as CARLA's BehaviorAgent does.
    """
    back = policy.hand_back
    if next_second(view, policy, curvature_per_m) is not None:
        return False
    if abs(view.ego_yaw) < back.askew_rad and abs(view.ego_d) < back.aside_m:
        return True
    case = CheckContext(view, _turning_back(view, back), policy, running=True)
    standing = np.flatnonzero(view.speed <= MOVING_MPS)
    if not len(standing):
        return True
    gap = stationary_gaps(case, standing)
    return not ((gap < back.kept_m) & (gap < gap[0] - policy.clearance.nearer_m)).any()


def next_second(view: FrenetScene, policy: GuardPolicy, curvature_per_m: float = 0.0) -> RejectReason | None:
    """Return the next contact of the driver if it drives on from here, or None.

    A stopped ego sets off with comfortable acceleration, and contacts within `HandBackPolicy.own_s` count. For a moving
    ego only those count that braking can no longer avoid: see `about_to_touch`.
    """
    if abs(view.ego.speed_mps) > policy.stopping.rests_mps:
        return about_to_touch(view, policy, curvature_per_m)
    t = _instants(policy.hand_back.own_s, policy)
    driven = view.ego.limits.comfort_acceleration_mps2 * t**2 / 2
    return _first(view, t, _touches(view, policy, driven, t, curvature_per_m), _touches(view, policy, 0 * t, t, 0.0))


def about_to_touch(view: FrenetScene, policy: GuardPolicy, curvature_per_m: float = 0.0) -> RejectReason | None:
    """Return the contact of the ego unless it brakes hard now, or None: the last time at which a stop still helps.

    The ego keeps its speed and its curve for `HandBackPolicy.check_s` and the time until the brakes act. Then it brakes
    as hard as it can. Moving objects keep their velocity; such an object counts only if braking at once avoids it.

    Args:
        view: Surroundings in road coordinates.
        policy: Policy of the guard.
        curvature_per_m: Curvature of the driven path (1/m, left positive).
    """
    speed = abs(view.ego.speed_mps)
    if speed <= MOVING_MPS:
        return None
    lag_s, brake = policy.stopping.lag_s, view.ego.limits.max_braking_mps2
    t = _instants(lag_s + policy.hand_back.check_s + speed / brake, policy)
    later = _braked_m(speed, brake, lag_s + policy.hand_back.check_s, t)
    now = _braked_m(speed, brake, lag_s, t)
    going_on = _touches(view, policy, later, t, curvature_per_m)
    return _first(view, t, going_on, _touches(view, policy, now, t, curvature_per_m))


def _instants(end_s: float, policy: GuardPolicy) -> Array:
    """(instants,): times from now up to `end_s` (s)."""
    count = 1 + int(np.ceil(end_s / policy.hand_back.step_s))
    result: Array = np.linspace(0.0, end_s, count)
    return result


def _braked_m(speed_mps: float, brake_mps2: float, delay_s: float, t: Array) -> Array:
    """(instants,): distance driven at constant speed for a time, then with braking (m)."""
    since = np.clip(t - delay_s, 0.0, speed_mps / brake_mps2)
    result: Array = speed_mps * np.minimum(t, delay_s) + speed_mps * since - brake_mps2 * since**2 / 2
    return result


def _touches(view: FrenetScene, policy: GuardPolicy, driven_m: Array, t: Array, curvature_per_m: float) -> Mask:
    """(instants, objects): True where the ego touches an object and is nearer to it than now.

    The objects have their most likely size: this check takes over from a driver, it accepts no plan.
    """
    ego = view.ego
    driven = driven_m if ego.speed_mps >= 0.0 else -driven_m
    half_turn = curvature_per_m * driven / 2
    # The rear axle moves along the heading. In a curve the center moves toward the inside, and the body cuts in.
    slip = math.asin(max(-1.0, min(curvature_per_m * ego.limits.wheelbase_m / 2, 1.0)))
    chord, bearing = driven * np.sinc(half_turn / np.pi), ego.yaw_rad + slip + half_turn
    x, y = ego.x_m + chord * np.cos(bearing), ego.y_m + chord * np.sin(bearing)
    others = view.objects
    vx, vy = (np.array([getattr(o, name) for o in others]) for name in ("vx_mps", "vy_mps"))
    gap = separation(
        (x[:, None], y[:, None], (ego.yaw_rad + 2 * half_turn)[:, None]),
        (ego.length_m / 2, ego.width_m / 2),
        (
            view.places[:, 0] + t[:, None] * vx,
            view.places[:, 1] + t[:, None] * vy,
            np.array([o.yaw_rad for o in others]),
        ),
        (np.array([o.length_m / 2 for o in others]), np.array([o.width_m / 2 for o in others])),
    )
    soft = np.array([_is_soft(view, i, policy) for i in range(len(view.objects))], dtype=bool)
    # An object at a distance of a few centimeters can come no nearer than these, so there every overlap counts.
    nearer = (gap < gap[:1] - policy.clearance.nearer_m) | ((gap < 0.0) & (gap[:1] >= 0.0))
    result: Mask = (gap < policy.harm.touch_m) & nearer & ~soft
    return result


def _is_soft(view: FrenetScene, i: int, policy: GuardPolicy) -> bool:
    """True for an object that a driver may drive over: soft by its class, and flat."""
    obj = view.objects[i]
    return obj.kind in PASSABLE_KINDS and obj.height_m <= policy.passable.height_m


def _first(view: FrenetScene, t: Array, going_on: Mask, stopping: Mask) -> RejectReason | None:
    """Return the first contact that stopping avoids; contacts with stationary objects always count."""
    helps = going_on & ~(stopping.any(axis=0) & view.moving)
    if not helps.any():
        return None
    when, member = (int(k[0]) for k in np.nonzero(helps))
    obj = view.objects[member]
    detail = f"{obj.kind.value} {obj.id}: contact after {t[when]:.1f} s of the driver's motion"
    return RejectReason(code=RejectCode.COLLISION, detail=detail, object_id=obj.id, time_s=float(t[when]))


def _turning_back(view: FrenetScene, policy: HandBackPolicy) -> FrenetPath:
    """Return an arc at the smallest radius to the road's direction, and a shift to the center of the route's lane."""
    radius, side = view.ego.limits.min_turn_radius_m, np.sign(view.ego_yaw)
    first = min(abs(view.ego_yaw), policy.most_turn_rad)
    turn = np.linspace(first, 0.0, SAMPLES)
    along = radius * (np.sin(first) - np.sin(turn))
    aside = side * radius * (np.cos(turn) - np.cos(first))
    s = np.append(np.arange(0.0, float(along[-1]), STEP_M), along[-1])
    arc = FrenetPath(view.ego_s + s, view.ego_d + np.interp(s, along, aside), np.full(len(s), policy.speed_mps))
    length = max(shortest_shift(arc.end_d, radius), STEP_M)
    return arc.then(lateral(arc.end_s, arc.end_d, 0.0, length, policy.speed_mps, view))
