"""Checks traffic in the ego's direction when the path moves sideways: ahead, alongside, and from behind."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.lane_entry import check_entry_gap, must_be_proven_now, tail_inside_border_s
from stucksolver.guard.verdict import RejectReason
from stucksolver.scene.frenet import Array, Mask
from stucksolver.scene.frenet_scene import MOVING_MPS
from stucksolver.scene.road import LaneDirection


def is_followed_lead(case: CheckContext, station: Array, which: Array, t: Array) -> Mask:
    """(profiles, instants, objects): True for a lead that the stack follows and therefore does not hit.

    The lead must be ahead of the ego's front bumper when the ego's body enters its path or is already in it. If the ego
    moves in behind it, or the plan has not begun, the distance must also suffice to brake to its speed. A vehicle
    reached while alongside is hit, not followed. So is a vehicle that the path leads around. The result is always False
    in an oncoming lane, because the ego cannot slow down and follow there. The second axis has length 1 if no object
    qualifies.

    Args:
        case: Plan being checked.
        station: (profiles, instants): arc lengths of the ego at the instants `t` (m).
        which: (objects,): indices of the objects.
        t: Instants (s).
    """
    view, policy = case.view, case.policy.prediction
    leads = (view.vs[which] > policy.along_mps) & (np.abs(view.vd[which]) < policy.steady_mps) & ~view.elsewhere[which]
    # A pedestrian is not a lead: an adaptive cruise control may not follow one.
    leads &= (view.s[which] + view.along[which] > view.ego_s) & ~view.on_foot[which] & case.traffic[which]
    leads &= np.array([view.objects[int(i)].id not in case.path.passes for i in which], dtype=bool)
    result = np.zeros((len(station), 1, len(which)), dtype=bool)
    for k in np.flatnonzero(leads):
        i = int(which[k])
        result[:, 0, k] = _is_ahead_of_ego(case, station, i, t) & _stays_behind(case, station, i, t)
    if result.any():
        result = result & _on_own_side(case, station)[..., None]
    return result


def _is_ahead_of_ego(case: CheckContext, station: Array, i: int, t: Array) -> Mask:
    """(profiles,): True if the object is ahead when the ego's body enters its path, or if the body never does."""
    view, path, policy = case.view, case.path, case.policy.entry
    gap_m = np.abs(np.interp(station, path.s, path.d) - view.d[i]) - np.interp(station, path.s, case.reach)
    meets = gap_m < view.across[i] + case.room_m(i)
    first = meets.argmax(axis=1)
    rows = np.arange(len(station))
    ahead = view.s[i] + view.vs[i] * t[first] - view.along[i] - station[rows, first] - view.ego.length_m / 2
    speed = np.interp(station[rows, first], path.s, case.quick.v)
    slower = np.maximum(speed**2 - view.vs[i] ** 2, 0.0) / (2 * view.ego.limits.comfort_braking_mps2)
    # If the plan begins behind the object, the ego must be able to fall back. In a running plan the stack does so.
    closing = np.maximum(speed - view.vs[i], 0.0)
    from_start = 0.0 if case.running else slower + closing * case.policy.stopping.lag_s
    needed = np.where(first > 0, policy.headway_s * speed + policy.headway_m + slower, from_start)
    result: Mask = ~meets.any(axis=1) | (ahead > needed)
    return result


def _stays_behind(case: CheckContext, station: Array, i: int, t: Array) -> Mask:
    """(profiles,): True if the ego remains in the object's path to the end, never reaches the object, or joins it.

    A stack falls back behind an object in the path of its body. It does not behind an object that the path leads around
    or passes at a small distance. To join means to move in behind the object, in line with it, and to leave its path
    before reaching it. If the object brakes meanwhile, the stack falls back, and `lane_entry` has kept the distance.
    """
    view, path, braking = case.view, case.path, case.policy.prediction.braking_mps2
    d = np.interp(station, path.s, path.d)
    # Without the uncertainty of the position: uncertainty alone makes no lead.
    half_m = np.interp(station, path.s, case.reach) + view.across[i] - view.uncertainty_m[i]
    meets: Mask = np.abs(d - view.d[i]) < half_m
    lane = view.lane_of[i]
    if lane is not None:
        # The object follows its lane, which may bend away from the route's line.
        aside = np.interp(station, lane.s, lane.center) - float(np.interp(view.s[i], lane.s, lane.center))
        meets |= np.abs(d - view.d[i] - aside) < half_m
    stays = meets | (np.cumsum(meets, axis=1) == 0)
    until = np.minimum(t, view.vs[i] / braking)
    rear = view.s[i] - view.along[i] + view.vs[i] * until - braking * until**2 / 2
    front, steady = station + view.ego.length_m / 2, view.s[i] - view.along[i] + view.vs[i] * t
    never_reached = (front < rear).all(axis=1)
    heading = np.interp(station, path.s, case.heading)
    in_line = (np.abs(d - view.d[i]) < case.policy.entry.in_line_m) & (
        np.abs(heading) < case.policy.tracking.parallel_rad
    )
    joins = (~meets[:, 0] | case.running) & in_line.any(axis=1) & ((front < steady) | ~meets).all(axis=1)
    result: Mask = (stays.all(axis=1) & meets.any(axis=1)) | never_reached | joins
    return result


def _on_own_side(case: CheckContext, station: Array) -> Mask:
    """(profiles, instants): True where the ego is outside all oncoming lanes."""
    oncoming = np.zeros(len(case.path.s), dtype=bool)
    for lane in case.path.enters:
        if lane.strip.direction is LaneDirection.OPPOSITE:
            oncoming |= case.inside(lane)
    result: Mask = np.interp(station, case.path.s, oncoming) < 1 / 2  # The nearest station decides.
    return result


def from_behind(case: CheckContext) -> list[RejectReason]:
    """Check that traffic approaching alongside from behind can stop behind the ego's body when it enters their path.

    The gap is the RSS distance at that time. Traffic directly behind the ego keeps its own distance.
    """
    view, path, policy = case.view, case.path, case.policy.entry
    coming = (view.vs > MOVING_MPS) & case.traffic & ~view.elsewhere
    for i in np.flatnonzero(coming & (view.s - view.along < view.ego_front_s)):
        on_left = bool(view.d[i] > path.d[0])
        side = 1.0 if on_left else -1.0
        gap_m = side * (view.d[i] - path.d) - view.across[i] - case.reach
        # A smaller gap at the start is accepted by the vehicle alongside. Only coming nearer reduces its space.
        least_m = policy.beside_people_m if view.vulnerable[i] else policy.beside_m
        room_m = min(least_m, float(gap_m[0]) - case.policy.clearance.nearer_m)
        border = float(view.d[i]) - side * (float(view.across[i]) + room_m)
        meets = gap_m < room_m
        if gap_m[0] <= 0.0 or not meets.any() or path.s[int(meets.argmax())] < view.ego_s:
            continue
        k = int(meets.argmax())
        if not must_be_proven_now(case, k):
            continue
        tail = tail_inside_border_s(case, k, np.full(len(path.s) - k, border), on_left)
        reject = check_entry_gap(case, k, int(i), tail)
        if reject is not None:
            return [reject]
    return []
