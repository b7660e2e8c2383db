"""The checks that need no prediction of oncoming traffic. Each returns its reasons against a plan."""

from __future__ import annotations

import numpy as np

from stucksolver.decision.behaviors import Release
from stucksolver.guard.case import Case
from stucksolver.guard.predict import moving_gaps, profiles, relevant, standing_gaps, times
from stucksolver.guard.verdict import Reject, RejectCode
from stucksolver.scene.frenet import Array, Lane
from stucksolver.scene.road import LaneDirection, LaneKind, LineKind
from stucksolver.scene.surroundings import ControlKind, LightState
from stucksolver.scene.view import MOVING_MPS


def collision(case: Case) -> list[Reject]:
    """No predicted overlap, and no gap below the bound for what the object is."""
    which = relevant(case)
    if not len(which):
        return []
    view = case.view
    stands = np.hypot(view.vs[which], view.vd[which]) <= MOVING_MPS
    standing, moving = which[stands], which[~stands]
    found: list[Reject] = []
    if len(standing):
        found += _too_near(case, standing, standing_gaps(case, standing), case.slow.t)
    if len(moving):
        t = times(case)
        stations = profiles(case, t)
        gap = moving_gaps(case, stations, moving, t)
        gap = np.where(_will_be_followed(case, stations, moving), np.maximum(gap, gap[:, :1]), gap)
        found += _too_near(case, moving, gap.min(axis=0), t)
    return found


def _too_near(case: Case, which: Array, gap: Array, t: Array) -> list[Reject]:
    """The objects whose gap (instants, objects) falls below the bound for what they are."""
    view, policy = case.view, case.policy
    margin = np.where(view.moving[which] > 0, policy.moving_gap_m, policy.standing_gap_m)
    margin = np.where(view.vulnerable[which] > 0, policy.vulnerable_gap_m, margin)
    # What is already nearer than the bound counts only when the plan brings it nearer still.
    bad = (gap < margin) & (gap < gap[0] - 0.05)
    return [
        _reject(case, int(which[k]), float(t[bad[:, k].argmax()]), float(gap[bad[:, k], k].min()))
        for k in np.flatnonzero(bad.any(axis=0))
    ]


def _reject(case: Case, index: int, time_s: float, gap_m: float) -> Reject:
    thing = case.view.objects[index]
    code = RejectCode.COLLISION if gap_m <= 0 else RejectCode.GAP
    if gap_m > 0 and case.view.vulnerable[index]:
        code = RejectCode.CLEARANCE
    detail = f"{thing.kind.value} {thing.id}: gap {gap_m:.1f} m after {time_s:.1f} s"
    return Reject(code=code, detail=detail, object_id=thing.id, time_s=time_s, gap_m=gap_m)


def _will_be_followed(case: Case, station: Array, which: Array) -> Array:
    """(profiles, times, objects): traffic ahead in a lane of our direction, which the stack follows rather than hits.

    It does not hold while the ego is in an oncoming lane: there it cannot slow down and follow.
    """
    view = case.view
    leads = (view.vs[which] > 0.5) & (view.s[which] > view.ego_s) & (np.abs(view.vd[which]) < 0.5)
    leads &= np.array([view.objects[int(i)].id not in case.path.passes for i in which])
    oncoming = np.zeros(len(case.path.s))
    for lane in case.path.enters:
        if lane.strip.direction is LaneDirection.OPPOSITE:
            oncoming = np.maximum(oncoming, case.inside(lane))
    own_side = np.interp(station, case.path.s, oncoming) < 0.5
    result: Array = own_side[..., None] & leads
    return result


def drivable_area(case: Case) -> list[Reject]:
    """The body stays on the driving lanes."""
    low, high = case.view.frame.drivable
    s = case.path.s
    stations = case.view.frame.s
    tolerance = case.policy.drivable_tolerance_m
    over_left = case.path.d + case.reach - np.interp(s, stations, high)
    over_right = np.interp(s, stations, low) - (case.path.d - case.reach)
    beyond = np.maximum(over_left, over_right)
    if case.path.end_s > case.view.frame.end_m:
        detail = "the path runs beyond the known road"
        return [Reject(code=RejectCode.OFF_ROAD, detail=detail)]
    # Where the ego already stands over an edge, it may leave it, but not go further out, and must end on the road.
    allowed = np.full(len(s), max(tolerance, float(beyond[0]) + 0.05))
    allowed[-1] = tolerance
    worst = int((beyond - allowed).argmax())
    if beyond[worst] <= allowed[worst]:
        return []
    detail = f"{beyond[worst]:.1f} m off the driving lanes, {s[worst] - s[0]:.0f} m ahead"
    return [Reject(code=RejectCode.OFF_ROAD, detail=detail, gap_m=-float(beyond[worst]))]


def speed(case: Case) -> list[Reject]:
    """The cap: low while recovering, higher for what a passenger asked for on the move."""
    policy = case.policy
    cap = policy.guided_speed_mps if case.guided else policy.recovery_speed_mps
    asked = float(case.path.speed.max())
    if asked <= cap + 1e-6:
        return []
    return [Reject(code=RejectCode.OVERSPEED, detail=f"asks {asked:.1f} m/s, the cap is {cap:.1f} m/s")]


OVER_THE_LINE_M = 1.0
"""A vehicle that stands with its bumper this far past a light's line has not passed the light."""


def stop_line(case: Case) -> list[Reject]:
    """No stop line is crossed unless its light is green; stop signs are left to the stack's own driving.

    While a plan runs, a line before which comfortable braking cannot stop any more is past mending.
    """
    ego = case.view.ego
    reach = case.path.end_s + ego.length_m / 2 - case.view.ego_front_s
    nearest = ego.speed_mps**2 / (2 * ego.limits.comfort_braking_mps2) if case.running else 0.0
    for control in case.view.surroundings.controls:
        light = control.kind is ControlKind.TRAFFIC_LIGHT
        least = nearest - (OVER_THE_LINE_M if light else 0.0)
        if control.applies is False or not least <= control.distance_m < reach:
            continue
        if light and control.state is not LightState.GREEN:
            state = control.state.value if control.state else "unknown"
            detail = f"{state} light {control.distance_m:.0f} m ahead"
            return [Reject(code=RejectCode.RED_LIGHT, detail=detail)]
        if control.kind is ControlKind.STOP_SIGN:
            detail = f"stop sign {control.distance_m:.0f} m ahead"
            return [Reject(code=RejectCode.STOP_LINE, detail=detail)]
    return []


def marking(case: Case) -> list[Reject]:
    """Kerbs never; solid lines only past a stationary obstruction, slowly, and where the policy says so."""
    for lane in case.path.enters:
        inside = case.inside(lane)
        edges = np.flatnonzero(np.abs(np.diff(inside)) > 0)
        outer = _outer(lane, case.start_lane, float(case.path.s[0]))
        for k in edges:
            lines = outer.lines(float(case.path.s[k]) - 2.0, float(case.path.s[k]) + 2.0)
            if LineKind.KERB in lines:
                return [Reject(code=RejectCode.OFF_ROAD, detail="the way leads over a kerb")]
            if LineKind.SOLID in lines:
                why = _against_solid(case, lane, int(k))
                if why:
                    return [Reject(code=RejectCode.SOLID_LINE, detail=f"solid line: {why}")]
    return []


def _outer(lane: Lane, start: Lane | None, s: float) -> Lane:
    """Of the lane entered and the lane left, the one further from the route, which owns the line between them."""
    if start is None or abs(lane.at(s)[1]) >= abs(start.at(s)[1]):
        return lane
    return start


def _against_solid(case: Case, lane: Lane, k: int) -> str | None:
    """Why a solid line may not be crossed into a lane at station `k`, None where it may."""
    policy, here = case.policy, float(case.path.s[k])
    if policy.solid_line == "forbid":
        return "crossing is forbidden here"
    if not case.approvals.cover("solid_line", Release(policy.solid_line)):
        return f"crossing needs the yes of the {policy.solid_line}"
    if case.path.speed[k] > policy.recovery_speed_mps:
        return "only at 20 km/h or less"
    if any(z.start_m - 3.0 < here < z.end_m + 3.0 for z in case.view.surroundings.road.zones):
        return "not in or at a junction or crossing"
    if lane.strip.direction is LaneDirection.OPPOSITE and _legal_way(case, here):
        return "there is a lane of our direction beside it"
    return _no_obstruction(case)


def _legal_way(case: Case, s: float) -> bool:
    """Is there a lane of our direction that may be entered from the route's own?"""
    for side in (+1, -1):
        lane = case.view.frame.beside(s, 0.0, side)
        if lane is None or lane.strip.kind is not LaneKind.DRIVING or lane.strip.direction is LaneDirection.OPPOSITE:
            continue
        if not lane.lines(s - 2.0, s + 2.0) & {LineKind.SOLID, LineKind.KERB}:
            return True
    return False


def _no_obstruction(case: Case) -> str | None:
    """Why what lies ahead is no stationary obstruction: nothing does, it moves, or it is a queue."""
    view, policy = case.view, case.policy
    ahead = np.flatnonzero((view.gap > -1.0) & (view.gap < 40.0) & (view.in_corridor(view.ego.width_m / 2) > 0))
    if not case.path.passes and not len(ahead):
        comes_back = case.path.returns and abs(float(case.path.d[0])) > 1.0
        return None if comes_back else "nothing stands in the way"
    for i in ahead:
        thing = view.objects[int(i)]
        if thing.stationary_s is None or thing.stationary_s < policy.solid_line_standing_s:
            return "what is ahead is not a stationary obstruction"
        moved = thing.moved_s_ago
        if not thing.hazard_lights and moved is not None and moved < policy.waits.queue_moved_within_s:
            return "what is ahead moved a moment ago: it may be a queue"
    return None
