"""Those of our own direction: ahead, abreast, and coming up beside us, when the path moves sideways."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.traffic import inside_of, is_due, too_close
from stucksolver.guard.verdict import Reject
from stucksolver.scene.frenet import Array, Mask
from stucksolver.scene.road import LaneDirection
from stucksolver.scene.view import MOVING_MPS


def will_be_followed(case: CheckContext, station: Array, which: Array, t: Array) -> Mask:
    """(profiles, 1 or instants, objects): is it traffic of our direction ahead, followed by the stack and not hit?

    Such is who is before our front when our body comes, or is, in their way: before it by more than a way to brake
    down to their speed where the path only moves in behind them, or the plan only begins. Whom it meets abreast is
    not followed but hit. Nor does it hold while the ego is in an oncoming lane: there it cannot slow down and follow.
    `station` (profiles, instants): arc lengths of the ego at the instants `t`.
    """
    view, policy = case.view, case.policy.prediction
    leads = (view.vs[which] > policy.along_mps) & (np.abs(view.vd[which]) < policy.steady_mps) & ~view.elsewhere[which]
    # Somebody on foot is no traffic: what keeps a distance to vehicles ahead may not see them as such.
    leads &= (view.s[which] + view.along[which] > view.ego_s) & ~view.on_foot[which]
    leads &= np.array([view.objects[int(i)].id not in case.path.passes for i in which], dtype=bool)
    result = np.zeros((len(station), 1, len(which)), dtype=bool)
    for k in np.flatnonzero(leads):
        result[:, 0, k] = _is_before_us(case, station, int(which[k]), t)
    if result.any():
        result = result & _on_own_side(case, station)[..., None]
    return result


def _is_before_us(case: CheckContext, station: Array, i: int, t: Array) -> Mask:
    """(profiles,): is one ahead when our body comes into their way? True where it never does."""
    view, path, policy = case.view, case.path, case.policy.entry
    room = np.abs(np.interp(station, path.s, path.d) - view.d[i]) - np.interp(station, path.s, case.reach)
    meets = room < view.across[i] + policy.beside_m
    first = meets.argmax(axis=1)
    ways = np.arange(len(station))
    ahead = view.s[i] + view.vs[i] * t[first] - view.along[i] - station[ways, first] - view.ego.length_m / 2
    speed = np.interp(station[ways, first], path.s, case.quick.v)
    slower = np.maximum(speed**2 - view.vs[i] ** 2, 0.0) / (2 * view.ego.limits.comfort_braking_mps2)
    # Who is behind them from the start must be able to fall back; while a plan runs the stack is about it already.
    closing = np.maximum(speed - view.vs[i], 0.0)
    from_start = 0.0 if case.running else slower + closing * case.policy.stopping.lag_s
    needed = np.where(first > 0, policy.headway_s * speed + policy.headway_m + slower, from_start)
    result: Mask = ~meets.any(axis=1) | (ahead > needed)
    return result


def _on_own_side(case: CheckContext, station: Array) -> Mask:
    """(profiles, instants): is the ego out of all oncoming lanes?"""
    oncoming = np.zeros(len(case.path.s), dtype=bool)
    for lane in case.path.enters:
        if lane.strip.direction is LaneDirection.OPPOSITE:
            oncoming |= case.inside(lane)
    result: Mask = np.interp(station, case.path.s, oncoming) < 1 / 2  # the nearer station decides
    return result


def from_behind(case: CheckContext) -> list[Reject]:
    """Who comes up beside us in our direction, in our lane too, can stop behind whatever comes into their way.

    The gap is that of RSS at the moment at which our body reaches their way. Who is behind our body keeps their own
    distance.
    """
    view, path, policy = case.view, case.path, case.policy.entry
    for i in np.flatnonzero((view.vs > MOVING_MPS) & ~view.elsewhere & (view.s - view.along < view.ego_front_s)):
        left_of_us = bool(view.d[i] > path.d[0])
        side = 1.0 if left_of_us else -1.0
        beside = side * (view.d[i] - path.d) - view.across[i] - case.reach
        # Where there is less room from the start, who is beside us still has it; what is nearer still takes it away.
        least_m = policy.beside_people_m if view.vulnerable[i] else policy.beside_m
        room_m = min(least_m, float(beside[0]) - case.policy.clearance.nearer_m)
        border = float(view.d[i]) - side * (float(view.across[i]) + room_m)
        meets = beside < room_m
        if beside[0] <= 0.0 or not meets.any() or path.s[int(meets.argmax())] < view.ego_s:
            continue
        k = int(meets.argmax())
        if not is_due(case, k):
            continue
        tail = inside_of(case, k, np.full(len(path.s) - k, border), left_of_us)
        reject = too_close(case, k, int(i), tail)
        if reject is not None:
            return [reject]
    return []
