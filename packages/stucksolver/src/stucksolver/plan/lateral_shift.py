"""How to move sideways past an obstacle just ahead: the longest shift that stays clear of it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stucksolver.plan.behaviors.behavior import BehaviorStart, NoPathError
from stucksolver.plan.frenet_path import FrenetPath, lateral, shortest_shift, turned_shift
from stucksolver.scene.boxes import separation
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import FrenetScene

NEARER_M = 0.05
LATER_M = 5.0
SHIFT_TIME_S = 3.0
"""About the duration of a lane change at speed."""
TURNED_RAD, STANDS_MPS = 0.15, 0.1
"""A vehicle that stands and points toward its goal by more than this has its nose out: it goes on from its heading."""
LENGTHS = 8
"""Number of lengths tried, from the gentlest to the tightest."""
CORNER_CLEARANCES_M = (0.8, 0.65, 0.5, 0.4, 0.32)
VULNERABLE_CORNER_CLEARANCES_M = (1.4, 1.3, 1.2, 1.1, 1.05)
"""Clearances planned for the body's corners while swinging out (m), from the desired to the smallest sufficient one.
The second list applies beside pedestrians and cyclists.
"""


def lateral_shift(
    view: FrenetScene, start: BehaviorStart, d_to: float, speed_mps: float, gentle_m: float = 0.0
) -> FrenetPath:
    """Return a lateral move to `d_to`, as long and thus as gentle as the space ahead allows.

    Args:
        view: The surroundings in road coordinates.
        start: Where the move begins.
        d_to: Lateral offset at its end (m, left positive).
        speed_mps: Upper bound on the speed (m/s).
        gentle_m: Least length of the gentlest move (m).

    Raises:
        CannotPlan: Even at its smallest turning radius the vehicle would touch something stationary ahead.
    """
    side = d_to - start.d_m
    standing = np.flatnonzero(~view.moving)
    nearest: list[tuple[FrenetPath, Array]] = []
    for path in _shifts(view, start, d_to, speed_mps, gentle_m):
        nearest.append((path, nearest_on_approach(view, path, standing)))
        if _is_clear(view, standing, nearest[-1][1], 0):
            return path
    for smaller in range(1, len(CORNER_CLEARANCES_M)):
        for path, gap in nearest:
            if _is_clear(view, standing, gap, smaller):
                return path
    way_there = start.s_m - view.ego_s
    if way_there > LATER_M:
        raise NoPathError(
            PlanFailure.NO_ROOM_TO_COME_BACK,
            f"no room to return by {abs(side):.1f} m, {way_there:.0f} m ahead: something is in the way",
        )
    raise NoPathError(
        PlanFailure.NO_SPACE_TO_PULL_AROUND,
        f"no room to swing out by {abs(side):.1f} m: the obstacle ahead is too near",
    )


def _shifts(
    view: FrenetScene, start: BehaviorStart, d_to: float, speed_mps: float, gentle_m: float
) -> Iterator[FrenetPath]:
    """Yield the moves to `d_to`, the gentlest first: with the nose out from its heading, then straight."""
    side = d_to - start.d_m
    shortest = max(shortest_shift(side, view.ego.limits.min_turn_radius_m), 4.0)
    gentle = max(min(SHIFT_TIME_S * max(start.speed_mps, 4.0), 40.0), shortest, gentle_m)
    lengths = [float(length) for length in np.linspace(gentle, shortest, LENGTHS)]
    if start.speed_mps < STANDS_MPS and abs(start.yaw_rad) > TURNED_RAD and side * start.yaw_rad > 0.0:
        for length in lengths:
            path = turned_shift((start.s_m, start.d_m), start.yaw_rad, d_to, length, speed_mps, view)
            if path is not None:
                yield path
    for length in lengths:
        yield lateral(start.s_m, start.d_m, d_to, length, speed_mps, view)


def nearest_on_approach(view: FrenetScene, path: FrenetPath, which: Array) -> Array:
    """(len(which),): the smallest gap of the body to objects on the path, where it is smaller than at its start (m).

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
    """True if these gaps to these objects are at least the clearances of one step of the two lists above."""
    least = np.where(view.vulnerable[which], VULNERABLE_CORNER_CLEARANCES_M[step], CORNER_CLEARANCES_M[step])
    return not bool((nearest_m < least).any())
