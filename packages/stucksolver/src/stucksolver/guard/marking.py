"""Painted lines: who may cross them, and when."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.numerics import KMH_PER_MPS
from stucksolver.guard.passable_obstacles import is_queued, may_be_vehicle
from stucksolver.guard.verdict import RejectReason
from stucksolver.plan.behaviors import ApprovalLevel
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Lane
from stucksolver.scene.road import LaneDirection, LaneKind, LineKind


def marking(case: CheckContext) -> list[RejectReason]:
    """Check that curbs are never crossed, and solid lines only slowly, past a stationary obstruction, as the policy
    allows.
    """
    near_m = case.policy.lanes.line_near_m
    for lane in case.path.enters:
        inside = case.inside(lane)
        edges = np.flatnonzero(inside[1:] != inside[:-1])
        outer = _outer(lane, case.start_lane, float(case.path.s[0]))
        for k in edges:
            lines = outer.lines(float(case.path.s[k]) - near_m, float(case.path.s[k]) + near_m)
            if LineKind.KERB in lines:
                return [RejectReason(code=RejectCode.OFF_ROAD, detail="the path crosses a kerb")]
            if LineKind.SOLID in lines:
                why = _against_solid(case, lane, int(k))
                if why:
                    return [RejectReason(code=RejectCode.SOLID_LINE, detail=f"solid line: {why}")]
    return []


def _outer(lane: Lane, start: Lane | None, s: float) -> Lane:
    """Return whichever of the two lanes is further from the route: it holds the line between them."""
    if start is None or abs(lane.at(s)[1]) >= abs(start.at(s)[1]):
        return lane
    return start


def _against_solid(case: CheckContext, lane: Lane, k: int) -> str | None:
    """Return why a solid line may not be crossed into a lane at station `k`, or None if it may."""
    policy, here = case.policy, float(case.path.s[k])
    if policy.solid_line == "forbid":
        return "crossing is forbidden here"
    if not case.approvals.cover("solid_line", ApprovalLevel(policy.solid_line)):
        return f"crossing needs approval from the {policy.solid_line}"
    if case.path.speed.max() > policy.speeds.recovery_mps:
        return f"only at {KMH_PER_MPS * policy.speeds.recovery_mps:.0f} km/h or less"
    margin_m = policy.lanes.zone_margin_m
    if any(z.start_m - margin_m < here < z.end_m + margin_m for z in case.view.surroundings.road.zones):
        return "not in or at a junction or crossing"
    if lane.strip.direction is LaneDirection.OPPOSITE and _legal_way(case, here):
        return "there is another lane in our direction"
    if lane.strip.direction is LaneDirection.SAME and case.view.sight_ahead_m(lane) < case.path.end_s - here:
        return "the lane beyond is not visible for the whole manoeuvre"
    return _no_obstruction(case)


def _legal_way(case: CheckContext, s: float) -> bool:
    """True if a lane in the ego's direction may be entered from the route's own lane."""
    near_m = case.policy.lanes.line_near_m
    for side in (+1, -1):
        lane = case.view.frame.beside(s, 0.0, side)
        if lane is None or lane.strip.kind is not LaneKind.DRIVING or lane.strip.direction is LaneDirection.OPPOSITE:
            continue
        if not lane.lines(s - near_m, s + near_m) & {LineKind.SOLID, LineKind.KERB}:
            return True
    return False


def _no_obstruction(case: CheckContext) -> str | None:
    """Return why there is no stationary obstruction ahead: nothing is there, it moves, or it is a queue."""
    view, policy = case.view, case.policy.lanes
    if _leaves_roadside(case):
        return None
    near = (view.gap > -policy.obstruction_behind_m) & (view.gap < policy.obstruction_ahead_m)
    ahead = np.flatnonzero(near & view.in_corridor(view.ego.width_m / 2))
    if not case.path.passes and not len(ahead):
        comes_back = case.path.returns and abs(float(case.path.d[0])) > policy.beside_route_m
        return None if comes_back else "nothing blocks the way"
    for i in ahead:
        thing = view.objects[int(i)]
        if thing.stationary_s is None or thing.stationary_s < policy.solid_line_standing_s:
            return "what is ahead is not a stationary obstruction"
        if not thing.hazard_lights and may_be_vehicle(case, int(i)) and is_queued(case, int(i)):
            return "what is ahead may be in a queue"
    return None


def _leaves_roadside(case: CheckContext) -> bool:
    """True if the path returns from a shoulder or parking strip: its line is the only way back, whoever is ahead."""
    start = case.start_lane
    return case.path.returns and not case.path.passes and start is not None and start.strip.kind is not LaneKind.DRIVING
