"""Smooths the motion of an axle: the least change of curvature within bounds on the offset and on the curvature.

The bounds are quadratic penalties, and each iteration of Newton's method solves for those that are active. It ends when
they no longer change. A caller checks the result, because a penalty lets a bound give by millimeters.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from stucksolver.plan.frenet_path import STEP_M
from stucksolver.scene.frenet import Array

BEND_WEIGHT, STEER_WEIGHT = 0.3, 10.0
"""Weights of the squared curvature and of its squared change. Ours."""
BOUND_WEIGHT = 1e6
"""Weight of the squared violation of a bound, in the same units. Ours."""
ROUNDS, ITERATIONS = 4, 6
"""Number of rounds, each with the bounds for the line of the round before, and iterations in each. Ours."""
SETTLED_M = 1e-3
"""Change of the offsets below which a further round changes nothing (m). Ours."""
PINNED = 3
"""Stations before the start and after the goal that hold the heading and the straight wheels there."""

Bounds = Callable[[Array], tuple[Array, Array]]
"""Returns the least and greatest offsets (stations,) (m) for the present offsets (stations,) (m)."""


@lru_cache(maxsize=64)
def _differences(count: int) -> tuple[Array, Array]:
    """Return the matrices of second and of third differences for `count` stations, per meter squared and cubed."""
    second = np.diff(np.eye(count), n=2, axis=0) / STEP_M**2
    return second, np.diff(second, axis=0) / STEP_M


def smooth(offsets: Array, slope: float, keep: float, bounds: Bounds, bend_limits: tuple[Array, Array]) -> Array:
    """Return smooth offsets with the same start, the same goal, and slope zero at the goal.

    Args:
        offsets: (stations,): offsets of the axle (m), every `STEP_M`.
        slope: Slope at the start.
        keep: Weight of the squared distance from `offsets`.
        bounds: Bounds on the offsets.
        bend_limits: (stations,): least and greatest curvature (1/m).

    Returns:
        (stations,): smooth offsets (m).
    """
    count = len(offsets)
    ahead_of_it = offsets[0] + slope * STEP_M * np.arange(-PINNED, 0)
    x = np.concatenate([ahead_of_it, offsets, np.full(PINNED, offsets[-1])])
    wanted = x.copy()
    second, third = _differences(len(x))
    free = slice(PINNED + 1, PINNED + count - 1)
    plain = BEND_WEIGHT * second.T @ second + STEER_WEIGHT * third.T @ third
    plain[np.diag_indices(len(x))] += keep
    low_bend, high_bend = (np.pad(limit, (PINNED - 1, PINNED - 1), mode="edge") for limit in bend_limits)
    for _ in range(ROUNDS):
        before = x
        low, high = bounds(x[PINNED : PINNED + count])
        active: tuple[bytes, ...] = ()
        for _ in range(ITERATIONS):
            inside, bend = x[PINNED : PINNED + count], second @ x
            off, bent = (inside < low) | (inside > high), (bend < low_bend) | (bend > high_bend)
            now = (off.tobytes(), bent.tobytes())
            if now == active:
                break
            active = now
            sides = np.clip(inside, low, high), np.clip(bend, low_bend, high_bend)
            x = _solved(x, wanted, plain, keep, free, (off, sides[0]), (bent, sides[1]), second)
        if np.abs(x - before).max() < SETTLED_M:
            break
    result: Array = x[PINNED : PINNED + count]
    return result


def _solved(
    x: Array,
    wanted: Array,
    plain: Array,
    keep: float,
    free: slice,
    offset: tuple[Array, Array],
    bend: tuple[Array, Array],
    second: Array,
) -> Array:
    """Return the offsets of least cost if the active bounds `(active, target)` on offset and curvature hold."""
    matrix, right = plain.copy(), keep * wanted
    where = PINNED + np.flatnonzero(offset[0])
    matrix[where, where] += BOUND_WEIGHT
    right[where] += BOUND_WEIGHT * offset[1][offset[0]]
    rows = second[bend[0]]
    matrix += BOUND_WEIGHT * rows.T @ rows
    right += BOUND_WEIGHT * rows.T @ bend[1][bend[0]]
    fixed = np.ones(len(x), dtype=bool)
    fixed[free] = False
    right = right[free] - matrix[free][:, fixed] @ x[fixed]
    solved: Array = x.copy()
    solved[free] = np.linalg.solve(matrix[free, free], right)
    return solved
