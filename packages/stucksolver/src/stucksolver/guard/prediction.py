"""Predicts objects (along their lane, straight on, braking), and computes the ego's gaps to them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.numerics import stopping_distance_m
from stucksolver.guard.through_traffic import ThroughTraffic, straight_on
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet import Array, Mask


def times(case: CheckContext) -> Array:
    """(instants,): times at which the plan is checked (s from now)."""
    policy = case.policy.prediction
    end = min(case.slow.duration_s, policy.horizon_s)
    result: Array = np.arange(0.0, end + policy.step_s, policy.step_s)
    return result


def relevant(case: CheckContext, span_s: float | None = None) -> Array:
    """(found,): indices of the objects that the ego can reach within `span_s` (default: the plan's duration).

    Traffic behind in the ego's direction is left out. It keeps its own distance, and the lane entry check covers the
    lanes that the ego moves into. Objects that the plan drives over are left out, too.
    """
    view, span = case.view, case.slow.duration_s if span_s is None else span_s
    if not view.objects:
        return np.zeros(0, dtype=int)
    policy, path = case.policy.prediction, case.path
    rear = view.ego_s - view.ego.length_m / 2
    same_direction = (view.vs > -policy.along_mps) & (np.abs(view.vd) < 2 * policy.crossing_mps)
    from_behind = (view.s + view.along < rear) & same_direction
    spare_m = policy.reserve_along_m
    move = np.abs(view.vs) * span + view.along + spare_m
    near_s = (view.s + move > path.s[0] - spare_m) & (view.s - move < path.end_s + spare_m)
    margin = view.across + np.abs(view.vd) * span + policy.reserve_across_m
    low, high = path.d.min() - case.reach.max(), path.d.max() + case.reach.max()
    near_d = (view.d + margin > low) & (view.d - margin < high)
    reach = view.speed * (span + policy.sure_s) + path.end_s - path.s[0] + view.half_length + view.ego.length_m
    reach = reach + policy.reserve_in_plane_m
    near = np.hypot(view.places[:, 0] - view.ego.x_m, view.places[:, 1] - view.ego.y_m) < reach
    indices: Array = np.flatnonzero((near_s & near_d & ~from_behind) | (view.elsewhere & near))
    if path.over:
        indices = np.array([i for i in indices if view.objects[int(i)].id not in path.over], dtype=int)
    return indices


def profiles(case: CheckContext, t: Array) -> Array:
    """(profiles, instants): arc lengths from the slow to the fast rollout, with no room for a body between them (m).

    The two bounds alone are not enough: an object may cross behind the fast ego and ahead of the slow one, but hit an
    ego in between.
    """
    slow = np.interp(t, case.slow.t, case.path.s)
    spread = np.interp(t, case.quick.t, case.path.s) - slow
    count = 2 + int(spread.max() / case.policy.prediction.between_profiles_m)
    result: Array = slow + np.linspace(0.0, 1.0, count)[:, None] * spread
    return result


def stationary_gaps(case: CheckContext, which: Array, aside_m: float = 0.0, part: float = 1.0) -> Array:
    """(stations, objects): gaps to stationary objects, for the ego at each station of the path (m).

    `aside_m` widens the objects on each side (m), and only the middle `part` of their length counts (1: all of it).
    """
    view, path = case.view, case.path
    return separation(
        (path.s[:, None], path.d[:, None], case.heading[:, None]),
        (view.ego.length_m / 2, view.ego.width_m / 2),
        (view.s[which], view.d[which], view.yaw[which]),
        (part * view.half_length[which], view.half_width[which] + aside_m),
    )


def gaps_at_heading(case: CheckContext, which: Array, way_m: float) -> Array:
    """(poses, objects): gaps to stationary objects while the ego drives `way_m` straight at its present heading (m).

    The poses are no further apart than the gap that counts as contact, so that no corner is skipped.
    """
    view, ego = case.view, case.view.ego
    ahead_m = np.linspace(0.0, way_m, 2 + int(way_m / case.policy.harm.touch_m))[:, None]
    return separation(
        (view.ego_s + ahead_m * np.cos(view.ego_yaw), view.ego_d + ahead_m * np.sin(view.ego_yaw), view.ego_yaw),
        (ego.length_m / 2, ego.width_m / 2),
        (view.s[which], view.d[which], view.yaw[which]),
        (view.half_length[which], view.half_width[which]),
    )


def is_on_drift_side(case: CheckContext, which: Array) -> Mask:
    """(objects,): True on the ego's side of the path, if its lateral error exceeds that of localization."""
    if abs(case.error_m) < case.policy.tracking.beside_m:
        return np.zeros(len(which), bool)
    result: Mask = (case.view.d[which] - case.view.ego_d) * case.error_m > 0.0
    return result


def moving_gaps(case: CheckContext, stations: Array, which: Array, t: Array) -> Array:
    """(profiles, instants, objects): gaps to moving objects (m), the smallest of all hypotheses; infinite if far away.

    `stations` (profiles, instants) are the ego's arc lengths (m) at the instants `t` (s); `which` (objects,) indices.
    """
    view, far_m = case.view, case.policy.prediction.far_m
    half_length, half_width = view.ego.length_m / 2, view.ego.width_m / 2
    offset = np.interp(stations, case.path.s, case.path.d)
    heading = np.interp(stations, case.path.s, case.heading)
    far = np.hypot(half_length, half_width) + np.hypot(view.half_length[which], view.half_width[which]) + far_m
    least = np.full((*stations.shape, len(which)), np.inf)
    straight = straight_on(case, which)
    if len(straight):
        least[..., straight.member] = _gaps_straight_on(case, stations, offset, heading, which, straight, t)
    # An object on a lane of the route's road may also follow it, whatever its heading.
    for member, s, d in predictions(case, which, t, np.flatnonzero(~view.elsewhere[which] | view.on_lane[which])):
        reach = far[member]
        near = np.nonzero((np.abs(s - stations[..., None]) < reach) & (np.abs(d - offset[..., None]) < reach))
        ego, (_, when, obj_index) = near[:2], near
        body = which[member][obj_index]
        gap = separation(
            (stations[ego], offset[ego], heading[ego]),
            (half_length, half_width),
            (s[when, obj_index], np.broadcast_to(d, s.shape)[when, obj_index], view.yaw[body]),
            (view.half_length[body], view.half_width[body]),
        )
        index = (*ego, member[obj_index])
        least[index] = np.minimum(least[index], gap)
    return least


def _gaps_straight_on(
    case: CheckContext, stations: Array, offset: Array, heading: Array, which: Array, straight: ThroughTraffic, t: Array
) -> Array:
    """(profiles, instants, members): gaps to objects that go straight on in the plane, or brake; infinite if far (m).

    The route has no information on the paths of these objects. Their timing is uncertain, so they are lengthened by
    their travel in a certain time. The time is longer before the start, so that no plan is aborted right after it.
    """
    view, speed, policy = case.view, straight.speed_mps, case.policy.prediction
    body_length, body_width = (half[which[straight.member]] for half in (view.half_length, view.half_width))
    x, y, along = (a.reshape(stations.shape) for a in view.frame.to_local(stations.ravel(), offset.ravel()))
    yaw = along + heading
    half_length, half_width = view.ego.length_m / 2, view.ego.width_m / 2
    reach = np.hypot(half_length, half_width) + np.hypot(body_length, body_width) + policy.far_m

    def gaps(driven_m: Array, longer_m: Array) -> Array:
        """(profiles, instants, members): gaps after each object has driven `driven_m` (instants, members) (m)."""
        beyond = driven_m - straight.before_m
        there_x = straight.x_m + np.cos(straight.yaw_rad) * beyond
        there_y = straight.y_m + np.sin(straight.yaw_rad) * beyond
        apart = (x[..., None] - there_x) ** 2 + (y[..., None] - there_y) ** 2
        near = np.nonzero((apart < (reach + longer_m) ** 2) & (beyond >= 0.0))
        ego, (_, when, obj_index) = near[:2], near
        result: Array = np.full(apart.shape, np.inf)
        result[near] = separation(
            (x[ego], y[ego], yaw[ego]),
            (half_length, half_width),
            (there_x[when, obj_index], there_y[when, obj_index], straight.yaw_rad[obj_index]),
            (body_length[obj_index] + longer_m[obj_index], body_width[obj_index]),
        )
        return result

    braking = np.minimum(t[:, None], speed / policy.braking_mps2)
    stopping_m = speed * braking - policy.braking_mps2 * braking**2 / 2
    early_m = speed * (policy.sure_running_s if case.running and not case.sets_off else policy.sure_s)
    nearest = np.minimum(gaps(speed * t[:, None], early_m), gaps(stopping_m, np.zeros(len(speed))))
    sets_off = (speed < policy.sets_off_mps) & ~view.on_foot[which[straight.member]]
    if not sets_off.any():
        return nearest
    # A vehicle that has just set off becomes faster. At its present speed it seems to arrive too late for a contact.
    faster = np.minimum(t[:, None], (policy.crosses_mps - speed) / policy.sets_off_mps2)
    driven_m = speed * t[:, None] + policy.sets_off_mps2 * (faster * t[:, None] - faster**2 / 2)
    result: Array = np.where(sets_off, np.minimum(nearest, gaps(driven_m, np.zeros(len(speed)))), nearest)
    return result


def predictions(case: CheckContext, which: Array, t: Array, everyone: Array) -> Iterator[tuple[Array, Array, Array]]:
    """Yield the hypotheses for `everyone` (indices into `which`): along the lane, braking, and straight on if crossing.

    Each is (members, s, d): indices into `which`, arc lengths (instants, members) (m), and offsets (the same shape, or
    one row for all instants) (m). An object that does not move along the road needs no braking hypothesis. An
    overtaking vehicle needs none either: if it brakes it falls behind, which is detected before the commit point and
    ends the plan. It counts as overtaking while it is beside the ego, as long as the ego can stop before it enters the
    path of that vehicle.
    """
    view, policy = case.view, case.policy.prediction
    vs, vd = view.vs[which], view.vd[which]
    still, steady = view.d[which][None, :], view.s[which] + vs * t[:, None]
    yield everyone, steady[:, everyone], still[:, everyone]
    crosses = np.abs(vd) > policy.crossing_mps
    quicker = vs > view.ego.speed_mps + policy.overtaking_mps
    beside = quicker & (view.s[which] > view.ego_s) & (view.s[which] - view.along[which] <= view.ego_front_s)
    passed = view.s[which] > view.ego_s
    passed[beside] = [not _stops_before(case, int(i)) for i in which[beside]]
    overtaking = quicker & ~passed & (np.abs(vd) < policy.crossing_mps)
    along = everyone[((np.abs(vs) > policy.crossing_mps) & ~overtaking)[everyone]]
    if len(along):
        speed = np.abs(vs[along])
        until = np.minimum(t[:, None], speed / policy.braking_mps2)
        travel = np.sign(vs[along]) * (speed * until - policy.braking_mps2 * until**2 / 2)
        yield along, view.s[which][along] + travel, still[:, along]
    across = everyone[crosses[everyone]]
    if len(across):
        yield across, steady[:, across], still[:, across] + vd[across] * t[:, None]


def _stops_before(case: CheckContext, i: int) -> bool:
    """True if the ego, braking now, stops before its body reaches the path of an object beside it."""
    view, path, ego = case.view, case.path, case.view.ego
    gap_m = np.abs(path.d - view.d[i]) - case.reach - view.across[i]
    meets = np.flatnonzero(gap_m < case.room_m(i))
    way_m = float(path.s[meets[0]] - path.s[0]) if len(meets) else np.inf
    return way_m > stopping_distance_m(ego.speed_mps, ego.limits.comfort_braking_mps2, case.policy.stopping.lag_s)
