"""Models the traffic that may come from occluded parts of an oncoming lane.

In the worst case a vehicle comes at the speed limit from the end of the sight distance. This case is assumed unless
more is known. If the lane begins at a junction that the route crosses straight on, and is visible up to there, only
traffic that enters the lane at the junction can come:

* A vehicle that turns in is no faster than the turn allows, v = sqrt(a R), and then accelerates to the limit.
* A vehicle that goes straight on uses the oncoming lane beyond the junction. If that lane is visible through the
  junction, the vehicle is no nearer than the end of the sight there. Otherwise it is as near as the junction, at the
  limit.

The model does not rely on lights or stop lines: the surroundings contain those for the ego, not those for others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.policy import OncomingPolicy
from stucksolver.scene.frenet import Lane
from stucksolver.scene.road import LaneDirection, LaneKind, Zone, ZoneKind


@dataclass(frozen=True)
class PhantomVehicle:
    """Hypothetical vehicle from an occluded area.

    Attributes:
        at_m: Distance of its front ahead of the ego's center when it appears (m).
        speed_mps: Speed at that time (m/s).
        limit_mps: Highest speed (m/s).
        accelerates_mps2: Acceleration up to that speed (m/s²).
    """

    at_m: float
    speed_mps: float
    limit_mps: float
    accelerates_mps2: float = 0.0

    def way_m(self, duration_s: float) -> float:
        """Return the distance that the vehicle drives in a time, accelerating to its highest speed (m)."""
        if self.speed_mps >= self.limit_mps or self.accelerates_mps2 <= 0.0:
            return self.speed_mps * duration_s
        gaining_s = min((self.limit_mps - self.speed_mps) / self.accelerates_mps2, duration_s)
        gained_m = self.speed_mps * gaining_s + self.accelerates_mps2 * gaining_s**2 / 2
        return gained_m + self.limit_mps * (duration_s - gaining_s)


def phantom_vehicles(case: CheckContext, lane: Lane) -> tuple[PhantomVehicle, ...]:
    """Return the phantom vehicles that may appear in an oncoming lane after the last check."""
    policy, sight = case.policy.oncoming, case.view.sight_ahead_m(lane)
    limit = lane.strip.speed_limit_mps or policy.unknown_limit_mps
    worst = PhantomVehicle(sight, limit, limit)
    zone = _begins_at(case, lane, sight)
    beyond = None if zone is None else _straight_on(case, lane, zone)
    if zone is None or beyond is None:
        return (worst,)
    quickest = max(turning_mps(zone.end_m - zone.start_m, policy), _quickest_in(case, zone))
    if quickest >= limit:
        return (worst,)
    return PhantomVehicle(sight, quickest, limit, policy.turned_accelerates_mps2), beyond


def turning_mps(length_m: float, policy: OncomingPolicy) -> float:
    """Return the highest speed in a turn within a junction of this length along the route (m/s): v = sqrt(a R).

    R is the largest radius of an arc that fits: a road that joins the route at `least_crossing_rad`, over the whole
    length of the junction.
    """
    return math.sqrt(policy.turning_mps2 * length_m / math.sin(policy.least_crossing_rad))


def _begins_at(case: CheckContext, lane: Lane, sight_m: float) -> Zone | None:
    """Return the junction at which the lane begins for its traffic, if the lane is visible up to there."""
    end_s, near_m = case.view.ego_s + sight_m, case.policy.sight.sampled_m
    if end_s < lane.end_m - near_m:
        return None
    zones = (zone for zone in case.view.surroundings.road.zones if zone.kind is ZoneKind.JUNCTION)
    return next((zone for zone in zones if abs(zone.start_m - lane.end_m) <= near_m), None)


def _straight_on(case: CheckContext, lane: Lane, zone: Zone) -> PhantomVehicle | None:
    """Return the phantom vehicle that goes straight on; None if the route turns there, or the lane is occluded."""
    view, policy = case.view, case.policy
    turns = abs(float(np.diff(np.interp([zone.start_m, zone.end_m], view.frame.s, view.frame.headings))[0]))
    if turns > policy.prediction.turns_rad:
        return None
    beyond = [
        item
        for item in view.frame.lanes
        if item.strip.direction is LaneDirection.OPPOSITE
        and item.strip.kind is LaneKind.DRIVING
        and item.start_m <= zone.end_m + policy.sight.sampled_m
        and item.end_m > zone.end_m + policy.sight.sampled_m
    ]
    if not beyond:
        return None
    sights = [view.sight_ahead_m(item) for item in beyond]
    if view.ego_s + min(sights) <= zone.end_m:
        return None
    limit = max(item.strip.speed_limit_mps or policy.oncoming.unknown_limit_mps for item in (lane, *beyond))
    return PhantomVehicle(min(sights), limit, limit)


def _quickest_in(case: CheckContext, zone: Zone) -> float:
    """Return the highest speed of visible traffic in a junction (m/s): occluded vehicles may be as fast."""
    view = case.view
    within = view.moving & ~view.on_foot & (view.s + view.along > zone.start_m) & (view.s - view.along < zone.end_m)
    return float(view.speed[within].max()) if within.any() else 0.0
