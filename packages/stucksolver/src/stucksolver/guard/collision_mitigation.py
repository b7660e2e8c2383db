"""Chooses the least harmful option if, after the commit point, continuing leads to a contact.

The order of preference is: no predicted contact; none with a person or two-wheeler; no stop on rails; the lowest impact
speed. Among equals: finish; brake gently, or hard if a contact is predicted for both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver.guard.abort_stops import braking_profile
from stucksolver.guard.adjacent_traffic import is_followed_lead
from stucksolver.guard.context import CheckContext
from stucksolver.guard.numerics import stopping_distance_m
from stucksolver.guard.prediction import (
    gaps_at_heading,
    is_on_drift_side,
    moving_gaps,
    profiles,
    relevant,
    stationary_gaps,
    times,
)
from stucksolver.plan.behaviors import AbortAction
from stucksolver.scene.frenet import Array, Mask
from stucksolver.scene.frenet_scene import MOVING_MPS


@dataclass(frozen=True)
class PredictedContact:
    """Predicted contact: whether it involves a person or two-wheeler, its relative speed (m/s) and its time (s).

    `time_s` is 0 for a stationary object.
    """

    person: bool
    speed_mps: float
    time_s: float = 0.0


@dataclass(frozen=True)
class EvasiveOption:
    """Evasive option. `brake_mps2` is the deceleration (m/s²); None if the ego does not brake."""

    abort: AbortAction
    brake_mps2: float | None = None


FINISH = EvasiveOption(AbortAction.FINISH)


def least_harmful_option(case: CheckContext, giving_way: bool) -> EvasiveOption:
    """Return whether to finish the plan or to brake. `giving_way`: True if the ego is already braking or stopped."""
    limits = case.view.ego.limits
    finishing = _finishing(case, giving_way)
    if finishing is None:
        return FINISH
    speed = abs(case.view.ego.speed_mps)
    # The rest of a stop that has begun is too short to matter.
    stops = giving_way and stopping_distance_m(speed, limits.comfort_braking_mps2, 0.0) < case.policy.harm.touch_m
    if (stops or speed < case.policy.stopping.rests_mps) and not case.on_rails(case.view.ego_s):
        # A driver that hits a stopped vehicle could have stopped; a stopped ego hits no object.
        return EvasiveOption(AbortAction.YIELD, limits.comfort_braking_mps2)
    # The ego stops until the other has passed, and no further object should arrive meanwhile.
    until_s = finishing.time_s + case.policy.stopping.stands_s
    options = [(_rank(finishing, on_rails=False), 0.0, FINISH)]
    # An ego that is already braking has no lag left, and should not release the brakes in between.
    lag_s = 0.0 if giving_way else case.policy.stopping.lag_s
    gentler_mps = 0.0 if giving_way else case.policy.harm.gentler_mps
    for braking in (limits.comfort_braking_mps2, limits.max_braking_mps2):
        contact, end_s = _stopping(case, braking, lag_s, until_s)
        # Of two stops that both end in a contact, the shorter one leaves more space to the other.
        harder = 0.0 if contact is None else -braking
        options.append(
            (_rank(contact, case.on_rails(end_s), gentler_mps), harder, EvasiveOption(AbortAction.YIELD, braking))
        )
    return min(options, key=lambda option: option[:2])[2]


def hard_braking_mps2(case: CheckContext) -> float | None:
    """Return the deceleration for a stop that is due now (m/s²); None if comfortable braking hits no object."""
    limits = case.view.ego.limits
    contact, _ = _stopping(case, limits.comfort_braking_mps2, case.policy.stopping.lag_s)
    return None if contact is None and not _drifts_into_passing_traffic(case) else limits.max_braking_mps2


def _drifts_into_passing_traffic(case: CheckContext) -> bool:
    """True if the ego, with comfortable braking, comes within touching distance of traffic that passes beside it.

    The body keeps its heading, away from the path, until it stops. Passing traffic meets its whole side, so the corner
    that reaches out furthest counts. Lengths in meters, in road coordinates.
    """
    view = case.view
    if case.error_m * case.error_rad <= 0.0:
        return False
    which = relevant(case)
    which = which[is_on_drift_side(case, which) & (view.speed[which] > MOVING_MPS)]
    way_m = stopping_distance_m(
        abs(view.ego.speed_mps), view.ego.limits.comfort_braking_mps2, case.policy.stopping.lag_s
    )
    half_length, half_width = view.ego.length_m / 2, view.ego.width_m / 2
    still_m = float(np.sin(min(abs(case.error_rad), np.pi / 2))) * way_m
    reach_m = half_length * abs(np.sin(view.ego_yaw)) + half_width * np.cos(view.ego_yaw)
    room_m = np.abs(view.d[which] - view.ego_d) - view.across[which] - reach_m - still_m
    abreast = np.abs(view.s[which] - view.ego_s) < view.along[which] + half_length + way_m
    return bool((abreast & (room_m < case.policy.harm.touch_m)).any())


def _rank(contact: PredictedContact | None, on_rails: bool, worse_mps: float = 0.0) -> tuple[bool, bool, bool, float]:
    if contact is None:
        return False, False, on_rails, 0.0
    return True, contact.person, on_rails, contact.speed_mps + worse_mps


def _finishing(case: CheckContext, giving_way: bool) -> PredictedContact | None:
    """Return the contact to which continuing leads, if it is time to act on it.

    Distant moving objects may be gone by that time, so the ego brakes only for near ones. An ego that has stopped or
    yields has more time and looks further ahead.
    """
    speed, braking = abs(case.view.ego.speed_mps), case.view.ego.limits.comfort_braking_mps2
    stopping = case.policy.stopping
    rests = giving_way or speed < stopping.rests_mps
    near_s = stopping.goes_on_s if rests else speed / braking + stopping.gives_way_s
    t = times(case)
    t = t[t <= near_s + case.policy.prediction.step_s]
    until_s = np.inf if rests else near_s
    standing = _with_standing(case, np.where(case.slow.t <= until_s, case.quick.v, np.nan))
    # The ego must act now on a contact that a stop one check later could not avoid.
    meets_mps = max(speed, case.policy.speeds.creep_mps) if rests else speed
    way_m = stopping_distance_m(meets_mps, braking, stopping.lag_s + case.policy.prediction.step_s)
    standing = _worse(standing, _drawn_against(case, way_m, 0.0))
    standing = _worse(standing, _beside_the_error(case, meets_mps))
    return _worse(standing, _with_moving(case, profiles(case, t), t))


def _stopping(
    case: CheckContext, braking_mps2: float, lag_s: float, until_s: float = 0.0
) -> tuple[PredictedContact | None, float]:
    """Return the contact to which braking now leads, and the arc length at which the ego stops (m).

    `lag_s` is the longest time until the brakes act (s). They may act at once, which counts for moving objects.
    `until_s` is the time until which the ego stays stopped at least (s from now).
    """
    stations, t = braking_profile(case, braking_mps2, lag_s, until_s)
    at_once, soonest = braking_profile(case, braking_mps2, 0.0, until_s)
    speed = np.interp(case.path.s, stations, np.gradient(stations, t), right=np.nan)
    speed[case.path.s > stations[-1]] = np.nan
    standing = _worse(_with_standing(case, speed), _drawn_against(case, float(np.ptp(stations)), braking_mps2, lag_s))
    both = np.stack([stations, np.interp(t, soonest, at_once)])
    return _worse(standing, _with_moving(case, both, t)), float(stations[-1])


def _worse(contact: PredictedContact | None, other: PredictedContact | None) -> PredictedContact | None:
    if contact is None or other is None:
        return contact or other
    return PredictedContact(
        contact.person or other.person, max(contact.speed_mps, other.speed_mps), max(contact.time_s, other.time_s)
    )


def _standing(case: CheckContext) -> Array:
    """(found,): indices of stationary objects that the ego can hit."""
    view, which = case.view, relevant(case)
    result: Array = which[view.speed[which] <= MOVING_MPS]
    return result


def _touched(case: CheckContext, gap: Array) -> Mask:
    """(poses, objects): True where the gap counts as contact and is smaller than at the first pose."""
    result: Mask = (gap < case.policy.harm.touch_m) & (gap < gap[0] - case.policy.clearance.nearer_m)
    return result


def _with_standing(case: CheckContext, speed_mps: Array) -> PredictedContact | None:
    """Return the worst of the first contacts with stationary objects.

    `speed_mps` (stations,) is the ego's speed at each station (m/s), NaN beyond the positions that it reaches.
    """
    which = _standing(case)
    if not len(which):
        return None
    hit = _touched(case, stationary_gaps(case, which)) & ~np.isnan(speed_mps)[:, None]
    member = np.flatnonzero(hit.any(axis=0))
    if not len(member):
        return None
    return PredictedContact(_has_vulnerable(case, which[member]), float(speed_mps[hit[:, member].argmax(axis=0)].max()))


def _drawn_against(
    case: CheckContext, way_m: float, braking_mps2: float, lag_s: float = 0.0
) -> PredictedContact | None:
    """Return the first contact with a stationary object on the ego's side of the path while its error grows.

    The body is assumed to keep its heading for `way_m` (m). After `lag_s` it brakes with `braking_mps2`, 0 for none.
    """
    if case.error_m * case.error_rad <= 0.0:
        return None
    which = _standing(case)
    which = which[is_on_drift_side(case, which)]
    if not len(which):
        return None
    hit = _touched(case, gaps_at_heading(case, which, way_m))
    member = np.flatnonzero(hit.any(axis=0))
    if not len(member):
        return None
    speed = abs(case.view.ego.speed_mps)
    first_m = way_m * hit[:, member].argmax(axis=0).min() / (len(hit) - 1)
    braked_m = max(first_m - speed * lag_s, 0.0)
    return PredictedContact(
        _has_vulnerable(case, which[member]), float(np.sqrt(max(speed**2 - 2 * braking_mps2 * braked_m, 0.0)))
    )


def _beside_the_error(case: CheckContext, speed_mps: float) -> PredictedContact | None:
    """Return the contact to which continuing or starting may lead beside a stationary object within touching distance.

    The path leads past the object, but the ego has left its path toward the object. If its steering fault persists, the
    ego comes nearer, by less than any prediction along the path shows. `speed_mps` is the speed of that contact (m/s).
    """
    which = _standing(case)
    which = which[is_on_drift_side(case, which)]
    if not len(which):
        return None
    member = which[gaps_at_heading(case, which, 0.0)[0] < case.policy.harm.touch_m]
    return PredictedContact(_has_vulnerable(case, member), speed_mps) if len(member) else None


def _with_moving(case: CheckContext, stations: Array, t: Array) -> PredictedContact | None:
    """Return the worst of the first contacts with moving objects, for several profiles along the path.

    `stations` (profiles, instants) are the ego's arc lengths (m) at the instants `t` (s). A pedestrian does not run
    into a stopped vehicle; a vehicle may.
    """
    view, which = case.view, relevant(case, float(t[-1]))
    which = which[view.speed[which] > MOVING_MPS]
    if not len(which):
        return None
    gap = moving_gaps(case, stations, which, t)
    gap = np.where(is_followed_lead(case, stations, which, t), np.maximum(gap, gap[:, :1]), gap)
    own = np.gradient(stations, t, axis=1)
    hit = (gap < case.policy.harm.touch_m) & (gap < gap[:, :1] - case.policy.clearance.nearer_m)
    hit &= ~(view.on_foot[which] & (own < MOVING_MPS)[..., None])
    profile, member = np.nonzero(hit.any(axis=1))
    if not len(profile):
        return None
    first = hit.argmax(axis=1)[profile, member]
    heading = np.interp(stations[profile, first], case.path.s, case.heading)
    along, across = own[profile, first] * np.cos(heading), own[profile, first] * np.sin(heading)
    speed = np.hypot(along - view.vs[which[member]], across - view.vd[which[member]])
    return PredictedContact(_has_vulnerable(case, which[member]), float(speed.max()), float(t[first].max()))


def _has_vulnerable(case: CheckContext, member: Array) -> bool:
    return bool((case.view.two_wheeled[member] | case.view.vulnerable[member]).any())
