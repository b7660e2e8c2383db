"""Riders beside the lanes, as on a bicycle lane, that will cross the route at a junction.

The lane graph knows the lanes of cars only. Whoever rides elsewhere is expected to ride straight on.
"""

from __future__ import annotations

import math

import numpy as np

from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.conflicting_traffic import ConflictingVehicle, vehicles_on_path
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.planner.pass_planner import TWO_WHEELER_M

RIDES_MPS = 2.0
"""Whoever is slower is about to stop, or can."""
MEETS_M = 1.7
"""Distance between the center lines at which bodies touch: half widths of a car and a bicycle, and 0.3 m."""
REACH_M = 60.0
"""Riders farther than this from the route are not looked at: 5 s at 12 m/s."""
_BEFORE_M, _AFTER_M = 1.0, 8.0
"""The part of the route looked at begins and ends so far beside the junction (m)."""
_IN_LANE_M = 1.2
_ALONG_COS = math.cos(math.radians(30.0))
_BODY_M = 2.0


def crossing_riders(
    line: Path, meeting: JunctionConflicts, around: NearbyObjects
) -> list[tuple[ConflictPath, ConflictingVehicle]]:
    """Return the riders that come to the route's way through a junction, each on a straight way of its own."""
    rides = (around.half_width < TWO_WHEELER_M) & ~around.is_walker & (np.hypot(around.vx, around.vy) > RIDES_MPS)
    riders = around.part(rides)
    if len(riders) == 0:
        return []
    known = {vehicle.actor_id for way in meeting.ways for vehicle in vehicles_on_path(way, riders)}
    inside = (line.s > meeting.wait_s - _BEFORE_M) & (line.s < meeting.last_s + _AFTER_M)
    own_s, own_yaw = line.s[inside], line.yaw[inside]
    course = np.arctan2(riders.vy, riders.vx)
    dx, dy = line.x[inside] - riders.x[:, None], line.y[inside] - riders.y[:, None]
    along = dx * np.cos(course)[:, None] + dy * np.sin(course)[:, None]
    aside = dy * np.cos(course)[:, None] - dx * np.sin(course)[:, None]
    near = (np.abs(aside) < MEETS_M) & (along > -_BODY_M) & (along < REACH_M)
    follows = (np.hypot(dx, dy) < _IN_LANE_M) & (np.cos(own_yaw - course[:, None]) > _ALONG_COS)
    comes = near.any(axis=1) & ~near[:, -1] & ~near[:, 0] & ~follows.any(axis=1)
    found = []
    for k in np.flatnonzero(comes).tolist():
        if riders.actor_id[k] not in known:
            rows = np.flatnonzero(near[k])
            way = _straight_way(riders, k, float(course[k]), along[k, rows], own_s[rows])
            speed = math.hypot(float(riders.vx[k]), float(riders.vy[k]))
            size = float(riders.half_length[k]), float(riders.half_width[k])
            found.append((way, ConflictingVehicle(riders.actor_id[k], 0.0, speed, *size)))
    return found


def _straight_way(riders: NearbyObjects, k: int, course: float, along: Array, own_s: Array) -> ConflictPath:
    s = np.array([0.0, REACH_M])
    meets, parts = max(float(along.min()), 0.0), float(along.max())
    return ConflictPath(
        x=riders.x[k] + s * math.cos(course),
        y=riders.y[k] + s * math.sin(course),
        yaw=np.full(2, course),
        s=s,
        inside_s=meets,
        meets_s=meets,
        parts_s=parts,
        route_meets_s=float(own_s[0]),
        route_parts_s=float(own_s[-1]),
        straight=True,
        bend_mps=math.inf,
        joins=False,
        approach=(-1, 0, riders.actor_id[k]),
        goes_first=True,
        lights=(),
    )
