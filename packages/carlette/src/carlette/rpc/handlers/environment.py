"""Weather, street lights, level geometry, rays, debug shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from carlette.errors import RequestError
from carlette.geometry import Vector
from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession
from carlette.wire import encode
from carlette.world import rays
from carlette.world.settings import CLEAR_NOON

methods = Methods()

ANY_LABEL = 255
"""`carla.CityObjectLabel.Any`."""


@methods.value("get_weather_parameters")
def get_weather_parameters(session: ClientSession) -> list[float]:
    return list(session.world.weather)


@methods.void("set_weather_parameters")
def set_weather_parameters(session: ClientSession, weather: Sequence[float]) -> None:
    values = tuple(map(float, weather))
    if len(values) != len(CLEAR_NOON) or not all(map(math.isfinite, values)):
        raise RequestError(f"set_weather_parameters: give {len(CLEAR_NOON)} finite numbers, not {list(weather)}")
    session.world.weather = values


@methods.void("update_day_night_cycle", "update_lights_state", "enable_environment_objects", "draw_debug_shape")
def ignore_for_show(session: ClientSession, *_: Any) -> None:
    """Ignore the call: the server has no street lights, no buildings and no screen."""
    del session


@methods.void("set_annotations_traverse_translucency")
def ignore_translucency(session: ClientSession, *_: Any) -> None:
    del session


@methods.value("query_lights_state", "get_names_of_all_objects", "get_environment_objects")
def nothing_there(session: ClientSession, *_: Any) -> list[Any]:
    """Return an empty list: the server has no street lights and no scenery besides the actors."""
    del session
    return []


@methods.value("get_all_level_BBs")
def get_all_level_boxes(session: ClientSession, label: int) -> Any:
    """Return the boxes (world frame) of the actors with this `CityObjectLabel`; CARLA also returns scenery."""
    world = session.world
    return [
        encode.box(actor.box._replace(center=pose.apply(actor.box.center), rotation=pose.rotation))
        for actor in world.actors.values()
        if actor.tags and (label == ANY_LABEL or label in actor.tags) and (pose := world.pose(actor))
    ]


@methods.value("get_imui_gravity")
def get_imui_gravity(session: ClientSession) -> float:
    del session
    return 9.81


@methods.void("set_imui_gravity")
def ignore_gravity(session: ClientSession, gravity: float) -> None:
    del session, gravity


@methods.value("project_point")
def project_point(session: ClientSession, origin: Sequence[float], direction: Sequence[float], distance: float) -> Any:
    hits = _cast(session, encode.read_vector(origin), encode.read_vector(direction), distance)
    return [bool(hits), [list(hits[0].place if hits else Vector()), hits[0].label if hits else 0]]


@methods.value("cast_ray")
def cast_ray(session: ClientSession, start: Sequence[float], end: Sequence[float]) -> Any:
    first, last = encode.read_vector(start), encode.read_vector(end)
    way = Vector(last.x - first.x, last.y - first.y, last.z - first.z)
    length = math.sqrt(way.x**2 + way.y**2 + way.z**2)
    return [[list(hit.place), hit.label] for hit in _cast(session, first, way, length)] if length else []


def _cast(session: ClientSession, start: Vector, way: Vector, distance_m: float) -> list[rays.RayHit]:
    if not (start.is_finite() and way.is_finite() and math.isfinite(distance_m)) or not any(way):
        raise RequestError("a ray needs finite points and a direction; give real numbers")
    return rays.cast(session.world, start, way, distance_m)
