"""Plans the return to the ego's lane after a pass: it begins as soon as the tail is clear, and drives on or stops.

Where no cosine shift fits, the return is a searched path. The same search finds a whole pass from the ego's pose.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stucksolver.plan.behaviors.behavior import CREEP_MPS, BehaviorStart, NoPathError
from stucksolver.plan.frenet_path import STEP_M, FrenetPath, landing_m, return_path, shortest_shift, straight
from stucksolver.plan.object_gaps import bounded_speed, comes_too_near
from stucksolver.plan.passing_geometry import CLEARANCE_M, DOOR_M, PassPlan, standing_beyond
from stucksolver.plan.path_search import Goal, search_path
from stucksolver.scene.boxes import separation
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Array, Lane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.objects import VEHICLES

STOP_GAP_M = 2.0
"""Distance kept from a stationary object beyond (m). Ours."""
STRAIGHT_M = 1.0
"""Length before a stop on which the wheels are straight (m). Ours."""
LEAST_BACK_M = 6.0
"""Least length of the return (m). Ours."""
GENTLE_M = 12.0
"""Length of the gentlest return at low speed (m). Ours."""
GENTLE_S = 2.5
"""Duration of the gentlest return at higher speed (s): a brisk lane change."""
LENGTHS = 6
"""Number of lengths to try, from the gentlest to the tightest. Ours."""
SOONER_M = 0.5
"""Step with which an earlier start of the return is tried (m): a station of the path."""
CLEAR_M = 1.2
"""Gap from the tail to the passed objects, or the gap while alongside if that is smaller (m). A plan ends at a
tracking error of 0.9 m (`TrackingPolicy`), and the guard's bound of 0.3 m must hold until then. With 0.25 m plus
0.085 s times the speed, six of 3,900 plans in the guard's oracle returned into the passed objects, 0.6 to 0.9 m off
their path.
"""
CLEAR_PEOPLE_M = 1.4
"""The same for pedestrians and cyclists (m). Ours."""
MOVES_MPS = 0.5
"""Speed above which an object counts as moving (m/s): the return begins only after the ego has passed it."""
QUICK_MPS = 5.6
"""Speed above which a larger distance is kept from doors (m/s): just over 20 km/h."""
QUICK_DOOR_M = 1.15
"""Distance from doors above `QUICK_MPS` (m): the guard requires 1.1 m there."""
DOORS_PART = 0.5
"""Part of a vehicle's length, around its middle, in which the doors are: `DoorPolicy.part_of_length`."""


def way_back(
    view: FrenetScene, out: FrenetPath, passing: PassPlan, past_s: float, beside_mps: float, back_mps: float
) -> FrenetPath:
    """Return the path from the end of `out`, past the objects, into the ego's lane and along it.

    If a stationary object is just beyond, or the known road ends, the path stops before that.

    Args:
        view: Surroundings in road coordinates.
        out: Path out of the lane.
        passing: Objects to pass.
        past_s: Arc length at which the ego has passed all objects (m); the return may begin sooner.
        beside_mps: Upper bound on the speed until then (m/s).
        back_mps: Upper bound on the speed after that (m/s).

    Raises:
        NoPathError: The space is too short for a return.
    """
    tight, last_s = view.ego.limits.min_turn_radius_m, _last_s(view, passing)
    shortest = max(shortest_shift(out.end_d, tight), LEAST_BACK_M)
    gentle, landing = max(GENTLE_S * beside_mps, GENTLE_M, shortest), landing_m(back_mps) + 2.0
    for length in np.linspace(gentle, shortest, LENGTHS):
        back_s = _soonest(view, out, passing, past_s, float(length), beside_mps)
        over_s = back_s + float(length)
        stops = over_s + landing > last_s
        if stops and over_s + STRAIGHT_M > last_s:
            continue
        path = return_path(
            (out.end_s, out.end_d), back_s, float(length), min(over_s + landing, last_s), beside_mps, view
        )
        if comes_too_near(view, path, 0.0):
            continue
        path = replace(path, speed=np.where(path.s > over_s, back_mps, path.speed))
        return path.stopping() if stops else path
    text = f"no room to return: {last_s - back_s:.1f} m left, required {shortest + STRAIGHT_M:.1f} m"
    start = BehaviorStart(out.end_s, out.end_d, 0.0)  # it may slow down for the return
    try:
        return searched_way_home(view, start, passing, beside_mps, back_mps)
    except NoPathError as error:
        raise error.said_as(PlanFailure.NO_ROOM_TO_COME_BACK, text) from None


def _last_s(view: FrenetScene, passing: PassPlan) -> float:
    """Return the arc length at which the ego must be back in its lane and stopped (m)."""
    return min(standing_beyond(view, passing) - STOP_GAP_M - view.ego.length_m / 2, view.frame.end_m)


def searched_way_home(
    view: FrenetScene,
    start: BehaviorStart,
    passing: PassPlan,
    beside_mps: float,
    back_mps: float,
    lanes: tuple[Lane, ...] = (),
) -> FrenetPath:
    """Return a searched path from `start`, past the objects, into the ego's lane and along it; it may have to stop.

    Args:
        view: Surroundings in road coordinates.
        start: Start, in the oncoming lane or in the ego's own.
        passing: Stationary objects to pass.
        beside_mps: Upper bound on the speed until the ego is back (m/s).
        back_mps: Upper bound on the speed after that (m/s).
        lanes: Lanes that the path must not leave; the drivable area if there are none.

    Raises:
        NoPathError: There is no path, or the objects to pass move.
    """
    if passing.speed_mps > MOVES_MPS:
        raise NoPathError(PlanFailure.NO_ROOM_TO_COME_BACK, "the passed object moves")
    last_s, half = _last_s(view, passing), view.ego.length_m / 2
    goal = Goal(0.0, last_s - STRAIGHT_M, min(passing.far_s + half, last_s - STRAIGHT_M))
    back = search_path(view, start, goal, lanes, desired_m=CLEARANCE_M).within(beside_mps)
    back = bounded_speed(view, back, start.yaw_rad)
    room_m, landing = last_s - back.end_s, landing_m(back_mps) + 2.0
    stops = room_m < landing
    length_m = STEP_M * int(min(room_m, landing) / STEP_M)
    path = back.then(straight(back.end_s, 0.0, length_m, back_mps)) if length_m > 0.0 else back
    return path.stopping() if stops else path


def _soonest(
    view: FrenetScene, out: FrenetPath, passing: PassPlan, past_s: float, length_m: float, speed_mps: float
) -> float:
    """Return the first arc length at which a return of this length stays clear of the passed objects (m)."""
    back_s = past_s
    if passing.speed_mps > MOVES_MPS:
        return back_s
    passed = np.array([o.id in passing.ids for o in view.objects], dtype=bool)
    stationary = ~view.moving & (view.s - view.along < passing.far_s)
    which = np.flatnonzero(passed | stationary)
    while back_s - SOONER_M > out.end_s:
        sooner = back_s - SOONER_M
        path = return_path((out.end_s, out.end_d), sooner, length_m, sooner + length_m, speed_mps, view)
        if not _is_clear(view, path, which, speed_mps):
            break
        back_s = sooner
    return back_s


def _is_clear(view: FrenetScene, path: FrenetPath, which: Array, speed_mps: float) -> bool:
    """True if the body stays clear of the objects `which`, and above walking pace also of their doors."""
    body = (path.s[:, None], path.d[:, None], path.body(0.0, view.ego.limits.wheelbase_m)[:, None])
    size = (view.ego.length_m / 2, view.ego.width_m / 2)
    there = (view.s[which], view.d[which], view.yaw[which])
    gap = separation(body, size, there, (view.half_length[which], view.half_width[which]))
    if (gap < np.minimum(gap[0], np.where(view.vulnerable[which], CLEAR_PEOPLE_M, CLEAR_M))).any():
        return False
    vehicles = np.array([view.objects[int(i)].kind in VEHICLES for i in which], dtype=bool)
    if speed_mps <= CREEP_MPS or not vehicles.any():
        return True
    doors = separation(body, size, there, (DOORS_PART * view.half_length[which], view.half_width[which]))
    least = DOOR_M if speed_mps <= QUICK_MPS else QUICK_DOOR_M
    return not ((doors < np.minimum(doors[0], least)) & vehicles).any()
