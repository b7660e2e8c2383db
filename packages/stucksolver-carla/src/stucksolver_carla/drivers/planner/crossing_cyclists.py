"""Finds cyclists outside the car lanes, for example on a bicycle lane, that will cross the route at a junction.

The lane graph contains car lanes only. Cyclists outside car lanes are predicted to ride straight.
"""

from __future__ import annotations

import math

import numpy as np

from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.conflicting_traffic import ConflictingVehicle, vehicles_on_path
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.planner.pass_planner import TWO_WHEELER_M

RIDING_MPS = 2.0
"""Minimum speed of a cyclist that will not stop (m/s); a slower one is stopping, or can stop. Ours."""
CONFLICT_M = 1.7
"""Distance between the paths' center lines below which the boxes touch (m): half widths of car and bicycle, and
0.3 m."""
REACH_M = 60.0
"""Maximum distance of a cyclist from the route (m): 5 s at 12 m/s."""
_BEFORE_M, _AFTER_M = 1.0, 8.0
"""Lengths of the route before and after the junction in which a crossing counts (m). Ours."""
_IN_LANE_M = 1.2
"""Maximum distance from the route of a cyclist that follows it (m). Ours."""
_SAME_DIRECTION_COS = math.cos(math.radians(30.0))
"""Cosine of the maximum angle to the route of a cyclist that follows it. Ours."""
_REAR_M = 2.0
"""Distance behind the cyclist's position at which a crossing still counts (m). Ours."""


def crossing_riders(
    line: Path, junction: JunctionConflicts, around: NearbyObjects
) -> list[tuple[ConflictPath, ConflictingVehicle]]:
    """Return the cyclists that will cross the route at a junction, each with its straight path."""
    is_riding = (around.half_width < TWO_WHEELER_M) & ~around.is_walker & (np.hypot(around.vx, around.vy) > RIDING_MPS)
    riders = around.part(is_riding)
    if len(riders) == 0:
        return []
    ids_on_lanes = {vehicle.actor_id for path in junction.ways for vehicle in vehicles_on_path(path, riders)}
    is_inside = (line.s > junction.wait_s - _BEFORE_M) & (line.s < junction.last_s + _AFTER_M)
    own_s, own_yaw = line.s[is_inside], line.yaw[is_inside]
    course = np.arctan2(riders.vy, riders.vx)
    dx, dy = line.x[is_inside] - riders.x[:, None], line.y[is_inside] - riders.y[:, None]
    along = dx * np.cos(course)[:, None] + dy * np.sin(course)[:, None]
    aside = dy * np.cos(course)[:, None] - dx * np.sin(course)[:, None]
    is_near = (np.abs(aside) < CONFLICT_M) & (along > -_REAR_M) & (along < REACH_M)
    follows = (np.hypot(dx, dy) < _IN_LANE_M) & (np.cos(own_yaw - course[:, None]) > _SAME_DIRECTION_COS)
    will_cross = is_near.any(axis=1) & ~is_near[:, -1] & ~is_near[:, 0] & ~follows.any(axis=1)
    crossings = []
    for k in np.flatnonzero(will_cross).tolist():
        if riders.actor_id[k] not in ids_on_lanes:
            rows = np.flatnonzero(is_near[k])
            path = _straight_path(riders, k, float(course[k]), along[k, rows], own_s[rows])
            speed = math.hypot(float(riders.vx[k]), float(riders.vy[k]))
            size = float(riders.half_length[k]), float(riders.half_width[k])
            crossings.append((path, ConflictingVehicle(riders.actor_id[k], 0.0, speed, *size)))
    return crossings


def _straight_path(riders: NearbyObjects, k: int, course: float, along: Array, own_s: Array) -> ConflictPath:
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
