"""Weather, street lights, level geometry, rays, debug shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from carlette.errors import RequestError
from carlette.geometry import Vector
from carlette.rpc.registry import Methods
from carlette.rpc.session import Session
from carlette.wire import encode

methods = Methods()

ROADS_LABEL = 1
RAY_STEP_M = 0.5


@methods.value("get_weather_parameters")
def get_weather_parameters(session: Session) -> list[float]:
    return list(session.world.weather)


@methods.void("set_weather_parameters")
def set_weather_parameters(session: Session, weather: Sequence[float]) -> None:
    if not all(map(math.isfinite, weather)):
        raise RequestError("set_weather_parameters: a value is not finite; give real numbers")
    session.world.weather = tuple(map(float, weather))


@methods.void("update_day_night_cycle", "update_lights_state", "enable_environment_objects", "draw_debug_shape")
def ignore_for_show(session: Session, *_: Any) -> None:
    """Nobody looks: there are no street lights, no buildings and no screen."""
    del session


@methods.void("set_annotations_traverse_translucency")
def ignore_translucency(session: Session, *_: Any) -> None:
    del session


@methods.value("query_lights_state", "get_names_of_all_objects", "get_environment_objects", "get_all_level_BBs")
def nothing_there(session: Session, *_: Any) -> list[Any]:
    del session
    return []


@methods.value("get_imui_gravity")
def get_imui_gravity(session: Session) -> float:
    del session
    return 9.81


@methods.void("set_imui_gravity")
def ignore_gravity(session: Session, gravity: float) -> None:
    del session, gravity


@methods.value("project_point")
def project_point(session: Session, origin: Sequence[float], direction: Sequence[float], distance: float) -> Any:
    start, way = encode.read_vector(origin), encode.read_vector(direction)
    hit = ground_hit(session, start, way, distance)
    return [hit is not None, [list(hit or Vector()), ROADS_LABEL if hit else 0]]


@methods.value("cast_ray")
def cast_ray(session: Session, start: Sequence[float], end: Sequence[float]) -> Any:
    first, last = encode.read_vector(start), encode.read_vector(end)
    way = Vector(last.x - first.x, last.y - first.y, last.z - first.z)
    length = math.sqrt(way.x**2 + way.y**2 + way.z**2)
    hit = ground_hit(session, first, way, length) if length else None
    return [[list(hit), ROADS_LABEL]] if hit else []


def ground_hit(session: Session, start: Vector, way: Vector, distance_m: float) -> Vector | None:
    """Where a ray meets the road's surface from above; None where it does not within the distance."""
    length = math.sqrt(way.x**2 + way.y**2 + way.z**2)
    if not (start.is_finite() and way.is_finite() and math.isfinite(distance_m)) or length == 0.0:
        raise RequestError("a ray needs finite points and a direction; give real numbers")
    steps = max(1, min(4000, math.ceil(distance_m / RAY_STEP_M)))
    above: float | None = None
    for step in range(steps + 1):
        reach = distance_m * step / steps / length
        point = Vector(start.x + way.x * reach, start.y + way.y * reach, start.z + way.z * reach)
        ground = session.world.roads.ground(point)
        surface = ground.origin.z + (point.x - ground.origin.x) * ground.slope_x
        surface += (point.y - ground.origin.y) * ground.slope_y
        height = point.z - surface
        if (above is not None and above >= 0.0 > height) or height == 0.0:
            return Vector(point.x, point.y, surface)
        above = height
    return None
