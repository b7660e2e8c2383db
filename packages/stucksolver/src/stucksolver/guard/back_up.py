"""Checks the end of backing up. An ego that is already in a junction may back up within it or out of it."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.prediction import moving_gaps, relevant
from stucksolver.guard.traffic_rules import no_oncoming_lane, stopping_place
from stucksolver.guard.verdict import RejectReason
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Mask
from stucksolver.scene.road import Zone, ZoneKind


def backing_place(case: CheckContext) -> list[RejectReason]:
    """Check that the ego may stop where the path ends or, if it starts in a junction, that the end is no worse.

    No worse means: not on rails; not in a junction unless the ego is already in it; not on a crosswalk with people
    near; not in the path of a moving object that the ego does not already block.
    """
    view, end = case.view, case.path.end_s
    junction = view.zone_at(float(case.path.s[0]), ZoneKind.JUNCTION)
    if junction is None or view.zone_at(end) is None:
        return stopping_place(case)
    half = view.ego.length_m / 2
    for zone in view.surroundings.road.zones:
        if not (zone.start_m < end + half and end - half < zone.end_m) or zone == junction:
            continue
        if zone.kind is not ZoneKind.CROSSWALK or _people_near(case, zone):
            zone_name = zone.kind.value.replace("_", " ")
            return [RejectReason(code=RejectCode.STOPPING_PLACE, detail=f"the backing path ends in a {zone_name}")]
    return no_oncoming_lane(case) or _blocks_moving_object(case)


def _people_near(case: CheckContext, zone: Zone) -> bool:
    """True if a pedestrian or cyclist is on the crosswalk, or near enough to step onto it."""
    view, near_m = case.view, case.policy.backing.people_m
    along = (view.s > zone.start_m - near_m) & (view.s < zone.end_m + near_m)
    near = np.abs(view.d) - view.across < case.policy.scenes.beside_m
    return bool((view.vulnerable & along & near).any())


def _blocks_moving_object(case: CheckContext) -> list[RejectReason]:
    """Reject a stop in the path of a moving object that does not hit the ego at its present position."""
    view, policy = case.view, case.policy
    arrives_s = 0.0 if case.running else case.slow.duration_s
    t = np.arange(0.0, arrives_s + policy.stopping.goes_on_s, policy.prediction.step_s)
    which = relevant(case, float(t[-1]))
    which = which[view.moving[which]]
    if not len(which):
        return []
    ends = np.array([[case.path.end_s], [float(case.path.s[0])]]) + np.zeros(len(t))
    gap = moving_gaps(case, ends, which, t)
    contact: Mask = gap.min(axis=1) < policy.clearance.moving_gap_m
    worse = np.flatnonzero(contact[0] & ~contact[1])
    return [_blocked(case, int(which[k]), float(gap[0, :, k].min())) for k in worse[:1]]


def _blocked(case: CheckContext, index: int, gap_m: float) -> RejectReason:
    obj, required_m = case.view.objects[index], case.policy.clearance.moving_gap_m
    detail = (
        f"{obj.kind.value} {obj.id}: gap {gap_m:.2f} m between its predicted path and the end of the backing path, "
        f"required {required_m:.2f} m"
    )
    return RejectReason(code=RejectCode.GAP, detail=detail, object_id=obj.id, gap_m=gap_m)
