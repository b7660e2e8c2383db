"""The minimal risk condition: stop at the best place in reach, with hazard lights on, and call for help."""

from __future__ import annotations

import math
from collections.abc import Iterator

from stucksolver.guard import Guard
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import (
    BackUp,
    Behavior,
    Creep,
    HazardLights,
    KeepLane,
    PullOver,
    RejoinRoute,
    RequestAssistance,
)
from stucksolver.scene.frenet_scene import FrenetScene

CLEAR_M = 1.0
"""Distance kept between the body and a zone that it has left."""
CREEPS_M = 15.0
"""The longest distance to creep in order to reach a place to stand (m)."""
BACKS_M = 40.0
"""The longest distance to back up for it (m)."""
FURTHEST_M = 60.0
"""The longest distance to drive for it (m)."""
SPEED_MPS = 3.0
"""Speed of that drive (m/s)."""


def minimal_risk(guard: Guard, view: FrenetScene, reason: str) -> RecoveryPlan:
    """Return the plan for the minimal risk condition: hazard lights, drive to the best place in reach, stop, call."""
    lights, call = HazardLights(), RequestAssistance(reason=reason[:200])
    way = way_to_stand(guard, view)
    return RecoveryPlan(behaviors=(lights, call) if way is None else (lights, way, call))


def way_to_stand(guard: Guard, view: FrenetScene) -> Behavior | None:
    """Return the first way that the guard accepts: to the roadside, or out of a zone where nobody may stand.

    None if the ego may stay where it is, or if there is no such way.
    """
    return next((way for way in _ways(guard, view) if guard.accept([way], view, False)[0].accepted), None)


def stops_where_one_may_stand(guard: Guard, view: FrenetScene) -> bool:
    """True if a stop begun now ends outside junctions, crosswalks, level crossings and oncoming lanes."""
    if not guard.may_stand(view):
        return False
    speed = max(view.ego.speed_mps, 0.0)
    way = speed**2 / (2 * view.ego.limits.comfort_braking_mps2)
    return view.zone_at(view.ego_s + way) is None


def _ways(guard: Guard, view: FrenetScene) -> Iterator[Behavior]:
    yield from (PullOver(distance_m=distance) for distance in (20.0, 12.0))
    if guard.may_stand(view):
        return
    half, zone = view.ego.length_m / 2, view.zone_at(view.ego_s)
    if zone is None:
        yield RejoinRoute()
        return
    ahead = math.ceil(zone.end_m + CLEAR_M - (view.ego_s - half))
    if ahead <= CREEPS_M:
        yield Creep(distance_m=float(ahead))
    elif ahead <= FURTHEST_M:
        yield KeepLane(distance_m=float(ahead), speed_mps=SPEED_MPS)
    back = math.ceil(view.ego_s + half + CLEAR_M - zone.start_m)
    if back <= BACKS_M:
        yield BackUp(distance_m=float(back))
