"""Calls that require a renderer, named scenery or a ROS node.

They are rejected with a message, so that no client waits for pictures.
"""

from __future__ import annotations

from typing import Any

from carlette.errors import RequestError
from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession

methods = Methods()


@methods.void("apply_color_texture_to_objects", "apply_float_color_texture_to_objects")
def refuse_textures(session: ClientSession, names: list[str], *_: Any) -> None:
    del session
    raise RequestError(f"unable to find the objects {names} to apply the texture to: this server has no scenery")


@methods.void("enable_sensor_for_ros")
def refuse_ros(session: ClientSession, *_: Any) -> None:
    del session
    raise RequestError("enable_sensor_for_ros: this server has no ROS node of its own; use the ROS bridge")


@methods.void("disable_sensor_for_ros")
def leave_ros_off(session: ClientSession, *_: Any) -> None:
    del session


@methods.value("is_sensor_enabled_for_ros")
def is_sensor_enabled_for_ros(session: ClientSession, *_: Any) -> bool:
    del session
    return False


@methods.void("enable_gbuffers")
def refuse_gbuffers(session: ClientSession, *_: Any) -> None:
    del session
    raise RequestError("enable_gbuffers: this server has no renderer and so no g-buffers")


@methods.value("get_gbuffer_token")
def refuse_gbuffer_stream(session: ClientSession, *_: Any) -> None:
    del session
    raise RequestError("get_gbuffer_token: this server has no renderer and so no g-buffers")


@methods.void("set_ignored_vehicles")
def refuse_ignored_vehicles(session: ClientSession, actor_id: int, *_: Any) -> None:
    actor = session.actor(actor_id, "set_ignored_vehicles")
    raise RequestError(f"set_ignored_vehicles: the sensor {actor.type_id} cannot leave out vehicles here")


@methods.value("get_ignored_vehicles")
def get_ignored_vehicles(session: ClientSession, actor_id: int) -> list[int]:
    session.actor(actor_id, "get_ignored_vehicles")
    return []
