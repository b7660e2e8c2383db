"""Smooths the motion of an axle: the least change of curvature within bounds on the offset and on the curvature.

The bounds are quadratic penalties, and each iteration of Newton's method solves for those that are active. It ends when
they no longer change. A caller checks the result, because a penalty lets a bound give by millimeters.
"""

from __future__ import annotations

from collections.abc import Callable

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

SECOND = np.array([1.0, -2.0, 1.0]) / STEP_M**2
"""Second difference, per meter squared."""
THIRD = np.array([-1.0, 3.0, -3.0, 1.0]) / STEP_M**3
"""Third difference, per meter cubed."""

Bounds = Callable[[Array], tuple[Array, Array]]
"""Returns the least and greatest offsets (stations,) (m) for the present offsets (stations,) (m)."""


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
    plain = [np.zeros(len(x) - k) for k in range(len(THIRD))]
    plain[0] += keep
    add_squares(plain, SECOND, np.full(len(x) - 2, BEND_WEIGHT))
    add_squares(plain, THIRD, np.full(len(x) - 3, STEER_WEIGHT))
    low_bend, high_bend = (np.pad(limit, (PINNED - 1, PINNED - 1), mode="edge") for limit in bend_limits)
    for _ in range(ROUNDS):
        before = x
        low, high = bounds(x[PINNED : PINNED + count])
        active: tuple[bytes, ...] = ()
        for _ in range(ITERATIONS):
            inside, bend = x[PINNED : PINNED + count], np.convolve(x, SECOND, mode="valid")
            off, bent = (inside < low) | (inside > high), (bend < low_bend) | (bend > high_bend)
            now = (off.tobytes(), bent.tobytes())
            if now == active:
                break
            active = now
            sides = np.clip(inside, low, high), np.clip(bend, low_bend, high_bend)
            x = _solved(x, wanted, plain, keep, (off, sides[0]), (bent, sides[1]))
        if np.abs(x - before).max() < SETTLED_M:
            break
    result: Array = x[PINNED : PINNED + count]
    return result


def _solved(
    x: Array,
    wanted: Array,
    plain: list[Array],
    keep: float,
    offset: tuple[Array, Array],
    bend: tuple[Array, Array],
) -> Array:
    """Return the offsets of least cost if the active bounds `(active, target)` on offset and curvature hold."""
    bands, right = [band.copy() for band in plain], keep * wanted
    inside = slice(PINNED, len(x) - PINNED)
    bands[0][inside] += BOUND_WEIGHT * offset[0]
    right[inside] += BOUND_WEIGHT * offset[0] * offset[1]
    weights = BOUND_WEIGHT * bend[0]
    add_squares(bands, SECOND, weights)
    for k, factor in enumerate(SECOND):
        right[k : k + len(weights)] += factor * weights * bend[1]
    # The first and the last of the offsets inside are held as well.
    begin, end = PINNED + 1, len(x) - PINNED - 1
    held = x.copy()
    held[begin:end] = 0.0
    right -= _times(bands, held)
    solved: Array = x.copy()
    solved[begin:end] = solve_banded([band[begin : end - k] for k, band in enumerate(bands)], right[begin:end])
    return solved


def add_squares(bands: list[Array], stencil: Array, weights: Array) -> None:
    """Add the matrix of the sum of weighted squares of differences to a symmetric banded matrix.

    Args:
        bands: Diagonals from the main one upward; diagonal `k` has `k` elements less than the main one.
        stencil: Factors of neighboring values in each difference.
        weights: (rows,): weight of each difference.
    """
    for k in range(len(stencil)):
        for a in range(len(stencil) - k):
            bands[k][a : a + len(weights)] += stencil[a] * stencil[a + k] * weights


def _times(bands: list[Array], x: Array) -> Array:
    """Return the product of a symmetric banded matrix and a vector."""
    result: Array = bands[0] * x
    for k, band in enumerate(bands[1:], start=1):
        result[:-k] += band * x[k:]
        result[k:] += band * x[:-k]
    return result


def solve_banded(bands: list[Array], right: Array) -> Array:
    """Return the solution of a symmetric, positive definite system with three diagonals above the main one.

    Plain arithmetic, one row after the other: for some 200 rows a threaded dense solver takes longer, several times so
    on a busy machine, and its rounding depends on the processor.
    """
    main, first, second, third = (band.tolist() for band in bands)
    count, solution = len(main), right.tolist()
    first, second, third = [*first, 0.0], [*second, 0.0, 0.0], [*third, 0.0, 0.0, 0.0]
    for i in range(count):
        # The factors of the three rows above: L D L^T, in place.
        if i > 0:
            main[i] -= first[i - 1] ** 2 * main[i - 1]
            first[i] -= first[i - 1] * second[i - 1] * main[i - 1]
            second[i] -= first[i - 1] * third[i - 1] * main[i - 1]
            solution[i] -= first[i - 1] * solution[i - 1]
        if i > 1:
            main[i] -= second[i - 2] ** 2 * main[i - 2]
            first[i] -= second[i - 2] * third[i - 2] * main[i - 2]
            solution[i] -= second[i - 2] * solution[i - 2]
        if i > 2:
            main[i] -= third[i - 3] ** 2 * main[i - 3]
            solution[i] -= third[i - 3] * solution[i - 3]
        first[i], second[i], third[i] = first[i] / main[i], second[i] / main[i], third[i] / main[i]
    solution = [value / factor for value, factor in zip(solution, main, strict=True)] + [0.0] * 3
    for i in reversed(range(count)):
        solution[i] -= first[i] * solution[i + 1] + second[i] * solution[i + 2] + third[i] * solution[i + 3]
    return np.array(solution[:count])
