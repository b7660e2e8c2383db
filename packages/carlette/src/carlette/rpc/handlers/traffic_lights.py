"""Traffic lights."""

from __future__ import annotations

import math
from typing import Any

from carlette.camera.environment.repeater_lights import repeaters_of
from carlette.camera.models.mesh import Point
from carlette.camera.models.traffic_lights import HEAD_HALF, REPEATER_HEAD, heads
from carlette.errors import RequestError
from carlette.geometry import Box, Vector
from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession
from carlette.wire import encode
from carlette.world.traffic_lights import Color

methods = Methods()


@methods.void("set_traffic_light_state")
def set_traffic_light_state(session: ClientSession, actor_id: int, state: int) -> None:
    light = session.light(actor_id, "set_traffic_light_state")
    session.world.signals.set_color(light.index, Color(state))


def _set_time(session: ClientSession, actor_id: int, color: Color, seconds: float) -> None:
    light = session.light(actor_id, "set_traffic_light_time")
    if not (math.isfinite(seconds) and seconds >= 0):
        raise RequestError(f"the time of a traffic light cannot be {seconds} s; give 0 or more")
    session.world.signals.set_time(light.index, color, seconds)


@methods.void("set_traffic_light_green_time")
def set_traffic_light_green_time(session: ClientSession, actor_id: int, seconds: float) -> None:
    _set_time(session, actor_id, Color.GREEN, seconds)


@methods.void("set_traffic_light_yellow_time")
def set_traffic_light_yellow_time(session: ClientSession, actor_id: int, seconds: float) -> None:
    _set_time(session, actor_id, Color.YELLOW, seconds)


@methods.void("set_traffic_light_red_time")
def set_traffic_light_red_time(session: ClientSession, actor_id: int, seconds: float) -> None:
    _set_time(session, actor_id, Color.RED, seconds)


@methods.void("freeze_traffic_light")
def freeze_traffic_light(session: ClientSession, actor_id: int, freeze: bool) -> None:
    light = session.light(actor_id, "freeze_traffic_light")
    session.world.signals.freeze(freeze, light.index)


@methods.void("freeze_all_traffic_lights")
def freeze_all_traffic_lights(session: ClientSession, freeze: bool) -> None:
    session.world.signals.freeze(freeze)


@methods.void("reset_traffic_light_group")
def reset_traffic_light_group(session: ClientSession, actor_id: int) -> None:
    light = session.light(actor_id, "reset_traffic_light_group")
    signals = session.world.signals
    signals.reset([int(signals.lights.group[light.index])])


@methods.void("reset_all_traffic_lights")
def reset_all_traffic_lights(session: ClientSession) -> None:
    signals = session.world.signals
    signals.reset(range(len(signals.groups)))


@methods.value("get_group_traffic_lights")
def get_group_traffic_lights(session: ClientSession, actor_id: int) -> list[int]:
    light = session.light(actor_id, "get_group_traffic_lights")
    signals = session.world.signals
    rows = signals.lights.row[signals.members(light.index)]
    ids: list[int] = session.world.bodies.record["id"][rows].tolist()
    return ids


@methods.value("get_light_boxes")
def get_light_boxes(session: ClientSession, actor_id: int) -> Any:
    """Return the boxes of the heads in the world, as the cameras draw them, including those of a second post."""
    light = session.light(actor_id, "get_light_boxes")
    pose = session.world.pose(light)
    places = [*heads(round(light.box.center.x, 1)), *_repeated(session, light.index)]
    boxes = (Box(pose.apply(Vector(*place)), HEAD_HALF, pose.rotation) for place in places)
    return [encode.box(box) for box in boxes]


def _repeated(session: ClientSession, index: int) -> list[Point]:
    foot = repeaters_of(session.world.roads)[index]
    if foot is None:
        return []
    return [(foot[0] + REPEATER_HEAD[0], foot[1] + REPEATER_HEAD[1], foot[2] + REPEATER_HEAD[2])]
