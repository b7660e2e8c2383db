"""Ends a plan after a failure of perception past the commit point: slowly along the last proven path, to a stop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stucksolver.guard.abort_stops import no_stopping_place
from stucksolver.guard.context import CheckContext
from stucksolver.plan.frenet_path import LEAST_MPS, FrenetPath


def stopping_soon(case: CheckContext) -> FrenetPath:
    """Return the path up to the first place where the ego can stop and a vehicle may stop, or to its end.

    The ego never speeds up, and ends in a stop with comfortable braking. It stays on the path that was proven free
    with the last surroundings.

    Args:
        case: Rest of a proven path, with the last surroundings.
    """
    path, ego = case.path, case.view.ego
    now_mps, braking_mps2 = abs(ego.speed_mps), ego.limits.comfort_braking_mps2
    reached = path.s >= path.s[0] + now_mps**2 / (2 * braking_mps2)
    oncoming = np.zeros(len(path.s), dtype=bool)
    for lane in case.oncoming_lanes(path.end_s):
        oncoming |= case.inside(lane)
    places = np.flatnonzero(reached & ~oncoming & ~no_stopping_place(case))
    count = max(int(places[0]) + 1, 2) if len(places) else len(path.s)
    left_m = path.s[count - 1] - path.s[:count]
    # The bound stays above zero, since a controller that slows down exactly to zero stops short of the end.
    braked = np.maximum(np.sqrt(2 * braking_mps2 * left_m), LEAST_MPS)
    speed = np.minimum.accumulate(np.minimum(np.minimum(path.speed[:count], now_mps), braked))
    speed[-1] = 0.0
    return replace(path, s=path.s[:count], d=path.d[:count], speed=speed, yaw=None, stops=True)
