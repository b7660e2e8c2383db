"""Finds the longest lateral shift that stays clear of an obstacle just ahead; where none does, a searched path."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stucksolver.plan.behaviors.behavior import CREEP_MPS, BehaviorStart, NoPathError
from stucksolver.plan.frenet_path import FrenetPath, lateral, shortest_shift, turned_shift
from stucksolver.plan.object_gaps import bounded_speed
from stucksolver.plan.path_search import SPAN_M, Goal, search_path
from stucksolver.scene.boxes import separation
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Array, Lane
from stucksolver.scene.frenet_scene import FrenetScene

NEARER_M = 0.05
"""Least decrease of a gap that counts as approaching (m): `ClearancePolicy.nearer_m`."""
LATER_M = 5.0
"""Distance ahead from which a shift is a return to the lane, for the reject reason (m). Ours."""
SHIFT_TIME_S = 3.0
"""Duration of the gentlest shift (s): about that of a lane change at speed."""
GENTLE_MPS = 4.0
"""Least speed for which the length of the gentlest shift is computed (m/s). Ours."""
LEAST_LENGTH_M, MOST_LENGTH_M = 4.0, 40.0
"""Least length of a shift, and greatest length that follows from its duration (m). Ours."""
TURNED_RAD, STANDS_MPS = 0.15, 0.1
"""Least heading toward the goal (rad) and greatest speed (m/s) of an ego that has nosed out. It continues from its
present heading. Ours.
"""
LENGTHS = 8
"""Number of lengths to try, from the gentlest to the tightest. Ours."""
CORNER_CLEARANCES_M = (0.8, 0.65, 0.5, 0.4, 0.32)
VULNERABLE_CORNER_CLEARANCES_M = (1.4, 1.3, 1.2, 1.1, 1.05)
"""Planned clearances of the body's corners during the shift (m), from the desired to the smallest sufficient one.

The second list applies to pedestrians and cyclists. The last values are just above the guard's bounds of 0.3 m and
1 m (`ClearancePolicy`). The others are ours.
"""


def lateral_shift(
    view: FrenetScene,
    start: BehaviorStart,
    d_to: float,
    speed_mps: float,
    gentle_m: float = 0.0,
    lanes: tuple[Lane, ...] = (),
) -> FrenetPath:
    """Return a lateral shift to `d_to`, as long and thus as gentle as the space ahead allows.

    Args:
        view: Surroundings in road coordinates.
        start: Start of the shift.
        d_to: Lateral offset at the end (m, left positive).
        speed_mps: Upper bound on the speed (m/s).
        gentle_m: Least length of the gentlest shift (m).
        lanes: Lanes that a searched path must not leave; those at the start and at `d_to` if there are none.

    Raises:
        NoPathError: The ego would touch a stationary object ahead even at its smallest turning radius.
    """
    standing = np.flatnonzero(~view.moving)
    nearest: list[tuple[FrenetPath, Array]] = []
    for path in _shifts(view, start, d_to, speed_mps, gentle_m):
        nearest.append((path, nearest_on_approach(view, path, standing)))
        if _is_clear(view, standing, nearest[-1][1], 0):
            return path
    for smaller in range(1, len(CORNER_CLEARANCES_M)):
        for path, gap in nearest:
            if _is_clear(view, standing, gap, smaller):
                return _slowed(view, path, float(path.heading()[0]))
    nearest_object = _too_near(view, standing, nearest[-1][1])
    return _searched(view, start, d_to, speed_mps, lanes or lanes_between(view, start, d_to), nearest_object)


def lanes_between(view: FrenetScene, start: BehaviorStart, d_to: float) -> tuple[Lane, ...]:
    """Return the lanes at the start and at an offset beside it (m); none if one of the two is off the lanes."""
    found = view.frame.lane_at(start.s_m, start.d_m), view.frame.lane_at(start.s_m, d_to)
    lanes = tuple(lane for lane in found if lane is not None)
    return lanes if len(lanes) == len(found) else ()


def _slowed(view: FrenetScene, path: FrenetPath, yaw_rad: float) -> FrenetPath:
    """Return the same path no faster than its gaps allow, and at walking pace throughout if one of them requires that.

    So a tight shift does not accelerate toward a door, where a small tracking error would be too much.
    """
    bounded = bounded_speed(view, path, yaw_rad)
    return bounded.within(CREEP_MPS) if bounded.speed.min() < CREEP_MPS + 0.1 else bounded


def _searched(
    view: FrenetScene,
    start: BehaviorStart,
    d_to: float,
    speed_mps: float,
    lanes: tuple[Lane, ...],
    too_near: tuple[str, str, float],
) -> FrenetPath:
    """Return a searched path to `d_to`; see `lateral_shift`. `too_near`: what the tightest shift comes too near to."""
    try:
        path = search_path(view, start, Goal(d_to, start.s_m + SPAN_M), lanes)
    except NoPathError as error:
        object_id, short, short_m = too_near
        way_there, side = start.s_m - view.ego_s, abs(d_to - start.d_m)
        failure, text = PlanFailure.NO_SPACE_TO_PULL_AROUND, f"no room to pull out by {side:.1f} m: {short}"
        if way_there > LATER_M:
            failure = PlanFailure.NO_ROOM_TO_COME_BACK
            text = f"no room to return by {side:.1f} m, {way_there:.0f} m ahead: {short}"
        raise error.said_as(failure, text, object_id, error.short_m or short_m) from None
    return _slowed(view, path.within(speed_mps), start.yaw_rad)


def _shifts(
    view: FrenetScene, start: BehaviorStart, d_to: float, speed_mps: float, gentle_m: float
) -> Iterator[FrenetPath]:
    """Yield the shifts to `d_to`, the gentlest first: after nosing out from the present heading, then straight."""
    side = d_to - start.d_m
    shortest = max(shortest_shift(side, view.ego.limits.min_turn_radius_m), LEAST_LENGTH_M)
    gentle = max(min(SHIFT_TIME_S * max(start.speed_mps, GENTLE_MPS), MOST_LENGTH_M), shortest, gentle_m)
    lengths = [float(length) for length in np.linspace(gentle, shortest, LENGTHS)]
    if start.speed_mps < STANDS_MPS and abs(start.yaw_rad) > TURNED_RAD and side * start.yaw_rad > 0.0:
        for length in lengths:
            path = turned_shift((start.s_m, start.d_m), start.yaw_rad, d_to, length, speed_mps, view)
            if path is not None:
                yield path
    for length in lengths:
        yield lateral(start.s_m, start.d_m, d_to, length, speed_mps, view)


def nearest_on_approach(view: FrenetScene, path: FrenetPath, which: Array) -> Array:
    """(len(which),): smallest gap between the body on the path and each object, if smaller than at the start (m).

    Infinite for an object that the body does not approach.
    """
    if not len(which):
        return np.zeros(0)
    gap = separation(
        (path.s[:, None], path.d[:, None], path.body(float(path.heading()[0]), view.ego.limits.wheelbase_m)[:, None]),
        (view.ego.length_m / 2, view.ego.width_m / 2),
        (view.s[which], view.d[which], view.yaw[which]),
        (view.half_length[which], view.half_width[which]),
    )
    nearest: Array = np.where(gap < gap[0] - NEARER_M, gap, np.inf).min(axis=0)
    return nearest


def _is_clear(view: FrenetScene, which: Array, nearest_m: Array, step: int) -> bool:
    """True if the gaps to these objects are at least the clearances of one step of the two lists above."""
    return not bool((nearest_m < _clearances(view, which, step)).any())


def _clearances(view: FrenetScene, which: Array, step: int) -> Array:
    """(len(which),): clearances from these objects in one step of the two lists above (m)."""
    return np.where(view.vulnerable[which], VULNERABLE_CORNER_CLEARANCES_M[step], CORNER_CLEARANCES_M[step])


def _too_near(view: FrenetScene, which: Array, nearest_m: Array) -> tuple[str, str, float]:
    """Return the id of the object that lacks the most clearance on the tightest shift, the gaps in words, and the lack
    (m).
    """
    required_m = _clearances(view, which, len(CORNER_CLEARANCES_M) - 1)
    k = int(np.argmax(required_m - nearest_m))
    obj = view.objects[int(which[k])]
    gap_m, least_m = max(float(nearest_m[k]), 0.0), float(required_m[k])
    return obj.id, f"{obj.kind.value} {obj.id}: gap {gap_m:.2f} m, required {least_m:.2f} m", least_m - gap_m
