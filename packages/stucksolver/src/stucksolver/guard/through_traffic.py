"""Models traffic that goes straight on where the route does not: on joining or crossing roads, or beside a turn."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.numerics import EPSILON
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.road import Zone, ZoneKind


@dataclass(frozen=True)
class ThroughTraffic:
    """Straight paths of objects in the local frame.

    Attributes:
        member: (members,): indices into the array of objects in the query.
        x_m: (members,): x of the start of the straight path (m).
        y_m: (members,): y of the start of the straight path (m).
        yaw_rad: (members,): heading of the straight path (rad).
        speed_mps: (members,): speed of the object (m/s).
        before_m: (members,): distance of the object to the start of the straight path (m).
    """

    member: Array
    x_m: Array
    y_m: Array
    yaw_rad: Array
    speed_mps: Array
    before_m: Array

    def __len__(self) -> int:
        return len(self.member)


def straight_on(case: CheckContext, which: Array) -> ThroughTraffic:
    """Return the straight paths of the objects in `which` that go straight on."""
    view = case.view
    rows = []
    for member in np.flatnonzero(view.elsewhere[which] | _oncoming(case, which)):
        i = which[member]
        obj, zone = view.objects[int(i)], _turned_in(case, int(i))
        speed = max(math.hypot(obj.vx_mps, obj.vy_mps), EPSILON)
        if view.elsewhere[i] or (zone is not None and view.s[i] <= zone.end_m):
            rows.append((member, obj.x_m, obj.y_m, math.atan2(obj.vy_mps, obj.vx_mps), speed, 0.0))
        elif zone is not None:
            x, y, along = view.frame.to_local(np.array([zone.end_m]), view.d[[int(i)]])
            rows.append((member, x[0], y[0], along[0] + math.pi, speed, float(view.s[i]) - zone.end_m))
    columns = np.array(rows, dtype=np.float64).reshape(-1, len(fields(ThroughTraffic))).T
    return ThroughTraffic(columns[0].astype(np.int64), *columns[1:])


def goes_straight(case: CheckContext, index: int) -> bool:
    """True if an object goes straight on where the route does not."""
    return bool(case.view.elsewhere[index]) or _turned_in(case, index) is not None


def _turned_in(case: CheckContext, index: int) -> Zone | None:
    """Return the junction in which the route turns off the road of an oncoming object, or None."""
    view = case.view
    if not _oncoming(case, index):
        return None
    first, last, half = float(case.path.s[0]), float(case.path.end_s), view.ego.length_m / 2
    for zone in view.surroundings.road.zones:
        overlaps = zone.start_m < last + half and zone.end_m > first - half
        if zone.kind is not ZoneKind.JUNCTION or not overlaps or view.s[index] <= zone.start_m:
            continue
        if _turns(view, zone) > case.policy.prediction.turns_rad:
            return zone
    return None


def _oncoming(case: CheckContext, which: Any) -> Any:
    """True for objects that move against the route on a known lane. `which`: one index or several."""
    view = case.view
    return (view.vs[which] < -case.policy.prediction.along_mps) & view.on_lane[which]


def _turns(view: FrenetScene, zone: Zone) -> float:
    """Return the angle by which the route turns in a zone (rad)."""
    start, end = (float(np.interp(s, view.frame.s, view.frame.headings)) for s in (zone.start_m, zone.end_m))
    return abs(end - start)
