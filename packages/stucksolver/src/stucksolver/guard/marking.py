"""Checks crossings of painted lines and curbs."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.leaving import leaves_rails
from stucksolver.guard.numerics import KMH_PER_MPS
from stucksolver.guard.passable_obstacles import is_queued, may_be_vehicle
from stucksolver.guard.verdict import RejectReason
from stucksolver.plan.behaviors import ApprovalLevel
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Lane
from stucksolver.scene.road import LaneDirection, LaneKind, LineKind
from stucksolver.scene.wording import stood_too_briefly


def marking(case: CheckContext) -> list[RejectReason]:
    """Check that no curb is crossed, and solid lines only slowly, past a stationary obstruction, with approval.

    A plan that leaves the rails into a lane in the ego's direction needs neither.
    """
    near_m = case.policy.lanes.line_near_m
    for lane in case.path.enters:
        inside = case.inside(lane)
        edges = np.flatnonzero(inside[1:] != inside[:-1])
        outer = _outer(lane, case.start_lane, float(case.path.s[0]))
        for k in edges:
            lines = outer.lines(float(case.path.s[k]) - near_m, float(case.path.s[k]) + near_m)
            if LineKind.KERB in lines:
                return [RejectReason(code=RejectCode.OFF_ROAD, detail="the path crosses a curb")]
            if LineKind.SOLID in lines:
                why = _against_solid(case, lane, int(k))
                if why:
                    return [RejectReason(code=RejectCode.SOLID_LINE, detail=f"solid line: {why}")]
    return []


def _outer(lane: Lane, start: Lane | None, s: float) -> Lane:
    """Return the lane that is further from the route: it has the line between the two."""
    if start is None or abs(lane.at(s)[1]) >= abs(start.at(s)[1]):
        return lane
    return start


def _against_solid(case: CheckContext, lane: Lane, k: int) -> str | None:
    """Return the reason against crossing a solid line into a lane at station `k`, or None if it is allowed."""
    policy, here = case.policy, float(case.path.s[k])
    if policy.solid_line == "forbid":
        return "crossing is forbidden here"
    leaving = lane.strip.direction is LaneDirection.SAME and leaves_rails(case)
    if not leaving and not case.approvals.cover("solid_line", ApprovalLevel(policy.solid_line)):
        return f"crossing requires approval from the {policy.solid_line}"
    fastest, cap = float(case.path.speed.max()), policy.speeds.recovery_mps
    if fastest > cap:
        return f"speed {KMH_PER_MPS * fastest:.0f} km/h, allowed {KMH_PER_MPS * cap:.0f} km/h"
    margin_m = policy.lanes.zone_margin_m
    for zone in () if leaving else case.view.surroundings.road.zones:
        if zone.start_m - margin_m < here < zone.end_m + margin_m:
            return f"crossing within {margin_m:.1f} m of a {zone.kind.value.replace('_', ' ')}"
    if lane.strip.direction is LaneDirection.OPPOSITE and _legal_way(case, here):
        return "another lane in the ego's direction may be entered"
    if lane.strip.direction is LaneDirection.SAME:
        sight_m, needed_m = case.view.sight_ahead_m(lane), case.path.end_s - here
        if sight_m < needed_m:
            return f"sight distance in the lane beyond {sight_m:.1f} m, required {needed_m:.1f} m"
    return None if leaving else _no_obstruction(case)


def _legal_way(case: CheckContext, s: float) -> bool:
    """True if the markings allow entry from the route's own lane into a lane in the ego's direction."""
    near_m = case.policy.lanes.line_near_m
    for side in (+1, -1):
        lane = case.view.frame.beside(s, 0.0, side)
        if lane is None or lane.strip.kind is not LaneKind.DRIVING or lane.strip.direction is LaneDirection.OPPOSITE:
            continue
        if not lane.lines(s - near_m, s + near_m) & {LineKind.SOLID, LineKind.KERB}:
            return True
    return False


def _no_obstruction(case: CheckContext) -> str | None:
    """Return the reason if there is no stationary obstruction ahead: none at all, a moving object, or a queue."""
    view, policy = case.view, case.policy.lanes
    if _leaves_roadside(case):
        return None
    near = (view.gap > -policy.obstruction_behind_m) & (view.gap < policy.obstruction_ahead_m)
    ahead = np.flatnonzero(near & view.in_corridor(view.ego.width_m / 2))
    if not case.path.passes and not len(ahead):
        comes_back = case.path.returns and abs(float(case.path.d[0])) > policy.beside_route_m
        return None if comes_back else "no obstruction in the path"
    for i in ahead:
        obj = view.objects[int(i)]
        if obj.stationary_s is None or obj.stationary_s < policy.solid_line_standing_s:
            still_s = obj.stationary_s or 0.0
            return f"{obj.kind.value} {obj.id} {stood_too_briefly(still_s, policy.solid_line_standing_s)}"
        if not obj.hazard_lights and may_be_vehicle(case, int(i)) and is_queued(case, int(i)):
            return f"{obj.kind.value} {obj.id} may be in a queue"
    return None


def _leaves_roadside(case: CheckContext) -> bool:
    """True if the path returns from a shoulder or parking strip: crossing its line is the only way back."""
    start = case.start_lane
    return case.path.returns and not case.path.passes and start is not None and start.strip.kind is not LaneKind.DRIVING
