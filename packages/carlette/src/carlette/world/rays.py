"""Hits of a ray through the world: the road's surface and actors' boxes."""

from __future__ import annotations

import math
from typing import NamedTuple

from carlette.geometry import Box, Pose, Rotation, Vector, rotate
from carlette.opendrive.road_network import RoadNetwork
from carlette.world.actor import ActorKind
from carlette.world.world import World

STEP_M = 0.5
"""Step of the search along the ray for the ground (m). Ours."""
MOST_STEPS = 4000
"""Maximum number of steps of that search. Ours."""
ROAD_LABEL, SIDEWALK_LABEL, TERRAIN_LABEL, STATIC_LABEL = 1, 2, 10, 20
"""Numbers of `carla.CityObjectLabel`."""
_X, _Y, _Z = Vector(x=1.0), Vector(y=1.0), Vector(z=1.0)


class RayHit(NamedTuple):
    """A point on a surface, and the `CityObjectLabel` of its object."""

    distance_m: float
    place: Vector
    label: int


def cast(world: World, start: Vector, way: Vector, distance_m: float) -> list[RayHit]:
    """Return the hits within `distance_m` of `start` in the direction `way` (any non-zero length), nearest first."""
    length = math.sqrt(way.x**2 + way.y**2 + way.z**2)
    unit = Vector(way.x / length, way.y / length, way.z / length)
    hits = [
        RayHit(reach, _along(start, unit, reach), actor.tags[0] if actor.tags else STATIC_LABEL)
        for actor in world.actors.values()
        if actor.kind in (ActorKind.VEHICLE, ActorKind.WALKER, ActorKind.PROP)
        and (reach := _box_reach(world.pose(actor), actor.box, start, unit)) is not None
        and reach <= distance_m
    ]
    ground = _ground_hit(world.roads, start, unit, distance_m)
    return sorted([*hits, ground] if ground else hits)


def _along(start: Vector, unit: Vector, reach_m: float) -> Vector:
    return Vector(start.x + unit.x * reach_m, start.y + unit.y * reach_m, start.z + unit.z * reach_m)


def _box_reach(pose: Pose, box: Box, start: Vector, unit: Vector) -> float | None:
    """Return the distance at which a ray enters a box (0 if it starts inside), or None if it misses it."""
    middle = pose.apply(box.center)
    gap = Vector(middle.x - start.x, middle.y - start.y, middle.z - start.z)
    enter, leave = 0.0, math.inf
    for axis, half in zip(_axes(pose.rotation), box.extent, strict=True):
        speed, offset = _dot(axis, unit), _dot(axis, gap)
        if abs(speed) < 1e-9:
            if abs(offset) > half:
                return None
            continue
        first, last = sorted(((offset - half) / speed, (offset + half) / speed))
        enter, leave = max(enter, first), min(leave, last)
    return enter if enter <= leave else None


def _axes(rotation: Rotation) -> tuple[Vector, Vector, Vector]:
    return rotate(_X, rotation), rotate(_Y, rotation), rotate(_Z, rotation)


def _dot(a: Vector, b: Vector) -> float:
    return a.x * b.x + a.y * b.y + a.z * b.z


def _ground_hit(roads: RoadNetwork, start: Vector, unit: Vector, distance_m: float) -> RayHit | None:
    """Return the point where a ray hits the surface from above.

    Beside the road, the nearest lane's surface continues.
    """
    steps = max(1, min(MOST_STEPS, math.ceil(distance_m / STEP_M)))
    before = _height(roads, start)
    for step in range(1, steps + 1):
        reach = distance_m * step / steps
        height = _height(roads, _along(start, unit, reach))
        if before >= 0.0 >= height:
            part = before / (before - height) if before > height else 0.0
            reach -= (1.0 - part) * distance_m / steps
            place = _along(start, unit, reach)
            return RayHit(reach, place, _ground_label(roads, place))
        before = height
    return None


def _height(roads: RoadNetwork, point: Vector) -> float:
    ground = roads.ground(point)
    surface = ground.origin.z + (point.x - ground.origin.x) * ground.slope_x
    return point.z - surface - (point.y - ground.origin.y) * ground.slope_y


def _ground_label(roads: RoadNetwork, place: Vector) -> int:
    lane = roads.waypoint(place)
    middle = lane.transform.location
    if math.hypot(place.x - middle.x, place.y - middle.y) > lane.lane_width / 2 + 0.01:
        return TERRAIN_LABEL
    return SIDEWALK_LABEL if lane.lane_type == roads.carla.LaneType.Sidewalk else ROAD_LABEL
