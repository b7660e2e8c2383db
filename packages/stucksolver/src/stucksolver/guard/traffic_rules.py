"""Checks rules of the road that a recovery may break, and the bounds of each behavior."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.leaving import blocks_moving_object, leaves, near_place_left, worse_place
from stucksolver.guard.numerics import EPSILON
from stucksolver.guard.verdict import RejectReason
from stucksolver.plan.frenet_path import landing_m
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Array
from stucksolver.scene.objects import ObjectKind, TrackedObject
from stucksolver.scene.road import LaneDirection, LaneKind, Zone, ZoneKind

IN_A_SCENE = (ObjectKind.FLAGGER, ObjectKind.CROSSING_GATE, ObjectKind.SCHOOL_BUS, ObjectKind.EMERGENCY)
"""Kinds that may mark a scene with its own rule in `SCENES`."""


def off_route(case: CheckContext) -> list[RejectReason]:
    """Check that the plan does not leave the route's own lane for too far or too long."""
    policy, path = case.policy.lanes, case.path
    home = case.view.frame.lane_at(float(path.s[0]), 0.0)
    if home is None:
        outside = np.abs(path.d) > policy.unknown_half_width_m
    else:
        right, left = np.interp(path.s, home.s, home.right), np.interp(path.s, home.s, home.left)
        outside = (path.d < right) | (path.d > left)
    if not outside.any():
        return []
    away_m = float(np.diff(path.s)[outside[1:]].sum())
    away_s = float(np.diff(case.slow.t)[outside[1:]].sum())
    if away_m <= policy.off_route_m and away_s <= policy.off_route_s:
        return []
    detail = (
        f"{away_m:.0f} m and {away_s:.0f} s off the route, "
        f"allowed {policy.off_route_m:.0f} m and {policy.off_route_s:.0f} s"
    )
    short_m, short_s = policy.off_route_m - away_m, policy.off_route_s - away_s
    reason = RejectReason(
        code=RejectCode.OFF_ROUTE, detail=detail, time_s=away_s, gap_m=short_m, margin=short_m, unit="m"
    )
    return [reason if short_m < 0.0 else reason.model_copy(update={"margin": short_s, "unit": "s"})]


def authority(case: CheckContext) -> list[RejectReason]:
    """Check that a level crossing, school bus, flagger or emergency scene is passed only with approval.

    An emergency scene requires none if the ego moves over by a whole lane. A plan that leaves a place where the ego
    must not stand requires none for that place, nor for what is there, except for a school bus. An ego that backs up
    passes only what is behind it.
    """
    view, policy = case.view, case.policy
    half = view.ego.length_m / 2
    start, end = float(case.path.s[0]) - half, float(case.path.end_s) + half
    scenes: list[tuple[str, str | None]] = [
        ("level_crossing", None)
        for zone in view.surroundings.road.zones
        if zone.kind is ZoneKind.LEVEL_CROSSING
        and start < zone.end_m
        and zone.start_m < end + policy.lanes.overrun_m
        and not leaves(case, zone)
    ]
    passed_from = start + view.ego.length_m if case.reverse else start
    for i, obj in enumerate(view.objects):
        rule = _scene_of(obj, policy.scenes.stands_mps) if obj.kind in IN_A_SCENE else None
        if rule is None:
            continue
        ahead = view.s[i] + view.along[i] > passed_from and view.s[i] - view.along[i] < end
        if not ahead or abs(view.d[i]) - view.across[i] >= policy.scenes.beside_m:
            continue
        if rule != "school_bus" and near_place_left(case, i):
            continue
        if rule != "emergency_scene" or not _moves_over(case, i):
            scenes.append((rule, obj.id))
    return [
        RejectReason(
            code=RejectCode.AUTHORITY,
            detail=f"{rule.replace('_', ' ')}: requires approval from the {policy.scene_release(rule).value}",
            object_id=object_id,
        )
        for rule, object_id in scenes
        if not case.approvals.cover(rule, policy.scene_release(rule))
    ]


def off_rails(case: CheckContext) -> list[RejectReason]:
    """Check, at the start, that no part of the body is on rails where the path ends or the stack takes over."""
    if case.running:
        return []
    path, view, half = case.path, case.view, case.view.ego.length_m / 2
    end, takes_over = float(path.end_s), float(path.end_s)
    if not path.stops and view.zone_at(float(path.s[0]), ZoneKind.LEVEL_CROSSING) is None:
        # An ego that leaves the rails must only be off them in the end.
        takes_over = max(end - landing_m(float(path.speed[-1])), float(path.s[0]))
    for zone in view.surroundings.road.zones:
        overlaps = zone.start_m < end + half + case.policy.lanes.overrun_m and takes_over - half < zone.end_m
        if zone.kind is ZoneKind.LEVEL_CROSSING and overlaps:
            return [RejectReason(code=RejectCode.STOPPING_PLACE, detail="the path ends on a level crossing")]
    return []


def full_exit(case: CheckContext) -> list[RejectReason]:
    """Check, at the start, that an ego that is handed over in a junction or on a crosswalk has room to leave it.

    Only objects that are stationary count. A place in which the ego is at the start is left anyway. Who enters a
    junction without room behind it blocks it (Vienna Convention on Road Traffic of 1968, article 18.2).
    """
    if case.running or case.path.stops:
        return []
    view, path, half = case.view, case.path, case.view.ego.length_m / 2
    zone = view.zone_at(path.end_s, ZoneKind.JUNCTION, ZoneKind.CROSSWALK)
    if zone is None or zone.start_m < path.s[0] + half:
        return []
    beside_m = view.ego.width_m / 2 + case.policy.harm.touch_m
    ahead = (view.s > path.end_s) & ~view.moving & (np.abs(view.d - path.end_d) - view.across < beside_m)
    if not ahead.any():
        return []
    rear_m = np.where(ahead, view.s - view.along, np.inf)
    first, needed_m = int(rear_m.argmin()), view.ego.length_m + case.policy.lanes.overrun_m
    room_m = float(rear_m[first]) - zone.end_m
    if room_m >= needed_m:
        return []
    obj, name = view.objects[first], zone.kind.value.replace("_", " ")
    detail = f"{obj.kind.value} {obj.id} behind the {name}: room {max(room_m, 0.0):.1f} m, required {needed_m:.1f} m"
    margin_m = room_m - needed_m
    return [RejectReason(code=RejectCode.STOPPING_PLACE, detail=detail, object_id=obj.id, margin=margin_m, unit="m")]


def _moves_over(case: CheckContext, i: int) -> bool:
    """True if object `i` is passed in a lane in the ego's direction that it leaves free over its whole width.

    "Move over" laws require that of drivers who pass a stopped emergency vehicle.
    """
    view, path, tolerance_m = case.view, case.path, case.policy.lanes.tolerance_m
    abreast = view.s[i] + view.along[i] * np.array([-1.0, 0.0, 1.0])
    for k in np.minimum(np.searchsorted(path.s, abreast), len(path.s) - 1):
        lane = view.frame.lane_at(float(path.s[k]), float(path.d[k]))
        if lane is None or lane.strip.direction is LaneDirection.OPPOSITE:
            return False
        if any(other.strip.direction is LaneDirection.OPPOSITE and case.inside(other)[k] for other in path.enters):
            return False
        right, _, left = lane.at(float(view.s[i]))
        if view.d[i] + view.across[i] > right + tolerance_m and view.d[i] - view.across[i] < left - tolerance_m:
            return False
    return True


def _scene_of(obj: TrackedObject, stands_mps: float) -> str | None:
    if obj.kind is ObjectKind.FLAGGER:
        return "flagger"
    if obj.kind is ObjectKind.CROSSING_GATE:
        return "level_crossing"
    if np.hypot(obj.vx_mps, obj.vy_mps) > stands_mps:
        return None
    if obj.kind is ObjectKind.SCHOOL_BUS:
        return "school_bus"
    # Lights without a known state may be on.
    return "emergency_scene" if obj.kind is ObjectKind.EMERGENCY and obj.emergency_lights is not False else None


def creep_speed(case: CheckContext) -> list[RejectReason]:
    """Check that behaviors that must be slow keep to walking pace."""
    fastest, cap = float(case.path.speed.max()), case.policy.speeds.creep_mps
    if fastest <= cap + EPSILON:
        return []
    detail = f"speed {fastest:.1f} m/s exceeds walking pace of {cap:.1f} m/s"
    return [RejectReason(code=RejectCode.OVERSPEED, detail=detail, margin=cap - fastest, unit="m/s")]


def within_lane(case: CheckContext) -> list[RejectReason]:
    """Check that the body stays within the lane in which the path begins."""
    lane = case.start_lane
    if lane is None:
        return [RejectReason(code=RejectCode.LEAVES_LANE, detail="the ego is in no lane")]
    s, d, policy = case.path.s, case.path.d, case.policy.lanes
    over: Array = np.maximum(
        d + case.reach - np.interp(s, lane.s, lane.left), np.interp(s, lane.s, lane.right) - (d - case.reach)
    )
    # With its present heading the ego may already reach over a border; it must not go further.
    allowed = max(policy.tolerance_m, float(over[0]) + policy.further_out_m)
    if float(over.max()) <= allowed:
        return []
    detail = f"ego {over.max():.2f} m out of its lane, allowed {allowed:.2f} m"
    return [RejectReason(code=RejectCode.LEAVES_LANE, detail=detail, margin=allowed - float(over.max()), unit="m")]


def stopping_place(case: CheckContext) -> list[RejectReason]:
    """Check that the ego may stop where the path ends: in no junction, crosswalk, level crossing or oncoming lane."""
    end = case.path.end_s
    zone = case.view.zone_at(end) or case.view.zone_at(end + case.policy.lanes.overrun_m)
    return _no_oncoming_lane(case) if zone is None else [_ends_in(zone)]


def no_worse_place(case: CheckContext) -> list[RejectReason]:
    """Check that the ego may stop where the path ends, or that it ends in a less bad place than the one it leaves.

    Such a place is not in the path of a moving object that the ego does not block now.
    """
    zone = worse_place(case)
    return (_no_oncoming_lane(case) or blocks_moving_object(case)) if zone is None else [_ends_in(zone)]


def _ends_in(zone: Zone) -> RejectReason:
    zone_name = zone.kind.value.replace("_", " ")
    return RejectReason(code=RejectCode.STOPPING_PLACE, detail=f"the path ends in a {zone_name}")


def _no_oncoming_lane(case: CheckContext) -> list[RejectReason]:
    """Check that the path does not end in a lane of oncoming traffic."""
    end = case.path.end_s
    for lane in case.view.frame.lanes:
        if lane.strip.kind is not LaneKind.DRIVING or lane.strip.direction is not LaneDirection.OPPOSITE:
            continue
        if lane.covers(end, end) and case.inside(lane)[-1]:
            return [RejectReason(code=RejectCode.STOPPING_PLACE, detail="the path ends in an oncoming lane")]
    return []
