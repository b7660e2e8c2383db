"""Tells plans that leave a place where the ego must not stand from plans that enter one or wait in one.

Such places are level crossings, junctions, crosswalks and areas that are marked to be kept clear. Their rules keep the
ego out. For an ego that is already in such a place, the same rules would keep it there. So a plan that begins in a
place and ends outside leaves it, forward or backward. It needs no approval for that place. A plan that cannot end
outside may end where the ego is less of an obstacle than now. Contacts, gaps, sight, red lights and speed limits hold
for these plans as for all others.
"""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.prediction import moving_gaps, relevant
from stucksolver.guard.verdict import RejectReason
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Mask
from stucksolver.scene.road import Zone, ZoneKind

PLACES = (ZoneKind.KEEP_CLEAR, ZoneKind.CROSSWALK, ZoneKind.JUNCTION, ZoneKind.LEVEL_CROSSING)
"""Places where a vehicle must not stand, the worst last. Ours: a train cannot stop, crossing vehicles can, pedestrians
can walk around the ego, and an area that is marked to be kept clear is mostly empty.
"""


def places_left(case: CheckContext) -> tuple[Zone, ...]:
    """Return the places that the ego was in when the plan began and that no part of its body is in at the end.

    Two level crossings without room for the ego between them are one place, since the ego cannot leave one without
    the other. The ego must be on the middle of the first one or past it: it waits before the rails otherwise.
    """
    return tuple(place for place in _places(case) if not _touches(case, place, case.path.end_s))


def leaves_rails(case: CheckContext) -> bool:
    """True if the ego was on the rails, or past them, when the plan began, and leaves the level crossing."""
    return any(place.kind is ZoneKind.LEVEL_CROSSING and _reaches_middle(case, place) for place in places_left(case))


def near_place_left(case: CheckContext, i: int) -> bool:
    """True if object `i` is at a place that the plan leaves: a gate of the crossing, a vehicle at the exit.

    The ego must be on the middle of the place, or past it and drive away from it. An ego that waits at a gate or before
    an officer with its front within the place would pass them to enter it.
    """
    view, near_m = case.view, case.policy.scenes.beside_m
    return any(
        view.s[i] + view.along[i] > place.start_m - near_m
        and view.s[i] - view.along[i] < place.end_m + near_m
        and _reaches_middle(case, place)
        for place in places_left(case)
    )


def leaves(case: CheckContext, zone: Zone) -> bool:
    """True if a zone is a place that the plan leaves, or a part of one."""
    return any(
        zone.kind is place.kind and place.start_m <= zone.start_m and zone.end_m <= place.end_m
        for place in places_left(case)
    )


def worse_place(case: CheckContext) -> Zone | None:
    """Return the zone that forbids a stop at the end of the path, or None.

    No zone does if the ego leaves a worse place, or if it comes nearer to the nearer exit of the same place. If it
    backs up in a junction, any way within the junction will do. No stop is allowed on rails, on a crosswalk with people
    near, and in a zone for a path that enters another lane.
    """
    places, end = _places(case), case.path.end_s
    began_in = {place.kind for place in places}
    for zone in case.view.surroundings.road.zones:
        if not _touches(case, zone, end):
            continue
        worse = PLACES[PLACES.index(zone.kind) + 1 :]
        better = not began_in.isdisjoint(worse) or (zone in places and _nearer_to_exit(case, zone))
        if not better or case.path.enters or zone.kind is ZoneKind.LEVEL_CROSSING or _people_near(case, zone):
            return zone
    return None


def blocks_moving_object(case: CheckContext) -> list[RejectReason]:
    """Reject a stop within a zone in the path of a moving object that does not hit the ego where it is now."""
    view, policy = case.view, case.policy
    if not any(_touches(case, zone, case.path.end_s) for zone in view.surroundings.road.zones):
        return []
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


def _places(case: CheckContext) -> tuple[Zone, ...]:
    """Return the zones that the body touched when the plan began, level crossings with those that adjoin them."""
    half = case.view.ego.length_m / 2
    zones = case.view.surroundings.road.zones
    found = [zone for zone in zones if zone.start_m < case.start_s + half and case.start_s - half < zone.end_m]
    return tuple(_with_tracks(case, zone) if zone.kind is ZoneKind.LEVEL_CROSSING else zone for zone in found)


def _reaches_middle(case: CheckContext, place: Zone) -> bool:
    """True if the ego's front was on the middle of a place or past it when the plan began."""
    return case.start_s + case.view.ego.length_m / 2 >= (place.start_m + place.end_m) / 2


def _with_tracks(case: CheckContext, zone: Zone) -> Zone:
    """Return a level crossing together with the next ones, as long as there is no room for the ego between them."""
    if not _reaches_middle(case, zone):
        return zone
    room_m = case.view.ego.length_m + 2 * case.policy.lanes.overrun_m
    rails = [other for other in case.view.surroundings.road.zones if other.kind is ZoneKind.LEVEL_CROSSING]
    # Each pass adds the crossings that adjoin the ones found so far.
    for _ in rails:
        adjoin = [o for o in rails if o.start_m < zone.end_m + room_m and zone.start_m - room_m < o.end_m]
        zone = Zone(kind=zone.kind, start_m=min(o.start_m for o in adjoin), end_m=max(o.end_m for o in adjoin))
    return zone


def _touches(case: CheckContext, zone: Zone, s: float) -> bool:
    """True if the body touches a zone after a stop at `s` (m), up to the error of such a stop."""
    half = case.view.ego.length_m / 2
    return zone.start_m < s + half + case.policy.lanes.overrun_m and s - half < zone.end_m


def _nearer_to_exit(case: CheckContext, zone: Zone) -> bool:
    if case.reverse and zone.kind is ZoneKind.JUNCTION:
        return True
    return _way_out_m(case, zone, case.path.end_s) < _way_out_m(case, zone, case.start_s)


def _way_out_m(case: CheckContext, zone: Zone, s: float) -> float:
    """Return the distance to the nearer end of a zone until the whole body at `s` (m) is out of it (m)."""
    half = case.view.ego.length_m / 2
    return min(s + half - zone.start_m, zone.end_m - s + half)


def _people_near(case: CheckContext, zone: Zone) -> bool:
    """True if a pedestrian or cyclist is on this crosswalk, or near enough to step onto it."""
    if zone.kind is not ZoneKind.CROSSWALK:
        return False
    view, near_m = case.view, case.policy.backing.people_m
    along = (view.s > zone.start_m - near_m) & (view.s < zone.end_m + near_m)
    near = np.abs(view.d) - view.across < case.policy.scenes.beside_m
    return bool((view.vulnerable & along & near).any())


def _blocked(case: CheckContext, index: int, gap_m: float) -> RejectReason:
    obj, required_m = case.view.objects[index], case.policy.clearance.moving_gap_m
    detail = (
        f"{obj.kind.value} {obj.id}: gap {gap_m:.2f} m between its predicted path and the end of the path, "
        f"required {required_m:.2f} m"
    )
    margin_m = gap_m - required_m
    return RejectReason(code=RejectCode.GAP, detail=detail, object_id=obj.id, gap_m=gap_m, margin=margin_m, unit="m")
