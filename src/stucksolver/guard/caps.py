"""Speed caps: low in a recovery, higher for a pass through the oncoming lane with nobody alongside."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.numerics import EPSILON
from stucksolver.guard.predict import standing_gaps
from stucksolver.guard.verdict import Reject
from stucksolver.scene.attempts import RejectCode
from stucksolver.scene.objects import VEHICLES
from stucksolver.scene.road import LaneDirection


def cap_mps(case: CheckContext) -> float:
    """Return the highest speed that a plan may ask for (m/s).

    A pass through the oncoming lane past stationary objects may use the lanes' speed limits, up to `passing_mps`,
    because a shorter pass meets less traffic. This does not hold beside people, within reach of a car door, or across
    a solid line (see `marking`).
    """
    speeds = case.policy.speeds
    if case.guided:
        return speeds.guided_mps
    borrowed = [lane for lane in case.path.enters if lane.strip.direction is LaneDirection.OPPOSITE]
    if not borrowed or not case.path.passes or _passes_who_moves(case) or _somebody_beside(case) is not None:
        return speeds.recovery_mps
    unknown = case.policy.oncoming.unknown_limit_mps
    lanes = [*borrowed, *([case.start_lane] if case.start_lane is not None else [])]
    limit = min(lane.strip.speed_limit_mps or unknown for lane in lanes)
    return max(min(speeds.passing_mps, limit), speeds.recovery_mps)


def too_quick(case: CheckContext, asked_mps: float) -> Reject:
    """Return the reason that refuses a plan above its cap. `asked_mps`: the highest speed of the plan (m/s)."""
    cap = cap_mps(case)
    beside = None if case.guided or cap > case.policy.speeds.recovery_mps else _somebody_beside(case)
    why = "" if beside is None else f" beside {case.view.objects[beside].kind.value} {case.view.objects[beside].id}"
    detail = f"asks for {asked_mps:.1f} m/s; the cap is {cap:.1f} m/s{why}"
    return Reject(code=RejectCode.OVERSPEED, detail=detail)


def _passes_who_moves(case: CheckContext) -> bool:
    return any(o.id in case.path.passes and case.view.moving[i] for i, o in enumerate(case.view.objects))


def _somebody_beside(case: CheckContext) -> int | None:
    """Return the index of a person, two-wheeler or car door within reach where the ego is faster than recovery speed.

    None if there is none.
    """
    view, speeds = case.view, case.policy.speeds
    quick = case.quick.v > speeds.recovery_mps + EPSILON
    if not quick.any():
        return None
    doored = np.array([o.kind in VEHICLES for o in view.objects], dtype=bool) & ~view.moving & ~view.two_wheeled
    people = view.vulnerable
    for which, aside_m, part in (
        (np.flatnonzero(people), speeds.people_aside_m, 1.0),
        (np.flatnonzero(doored & ~people), speeds.doors_aside_m, case.policy.doors.part_of_length),
    ):
        if len(which):
            gap = standing_gaps(case, which, aside_m=aside_m, part=part)[quick].min(axis=0)
            if (gap < 0.0).any():
                return int(which[int(gap.argmin())])
    return None
