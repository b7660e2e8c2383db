"""Traffic lights."""

from __future__ import annotations

import math
from typing import Any

from carlette.errors import RequestError
from carlette.rpc.registry import Methods
from carlette.rpc.session import Session
from carlette.wire import encode
from carlette.world.lights import Color

methods = Methods()


@methods.void("set_traffic_light_state")
def set_traffic_light_state(session: Session, actor_id: int, state: int) -> None:
    light = session.light(actor_id, "set_traffic_light_state")
    session.world.signals.set_color(light.index, Color(state))


def _set_time(session: Session, actor_id: int, color: Color, seconds: float) -> None:
    light = session.light(actor_id, "set_traffic_light_time")
    if not (math.isfinite(seconds) and seconds >= 0):
        raise RequestError(f"the time of a traffic light cannot be {seconds} s; give 0 or more")
    session.world.signals.set_time(light.index, color, seconds)


@methods.void("set_traffic_light_green_time")
def set_traffic_light_green_time(session: Session, actor_id: int, seconds: float) -> None:
    _set_time(session, actor_id, Color.GREEN, seconds)


@methods.void("set_traffic_light_yellow_time")
def set_traffic_light_yellow_time(session: Session, actor_id: int, seconds: float) -> None:
    _set_time(session, actor_id, Color.YELLOW, seconds)


@methods.void("set_traffic_light_red_time")
def set_traffic_light_red_time(session: Session, actor_id: int, seconds: float) -> None:
    _set_time(session, actor_id, Color.RED, seconds)


@methods.void("freeze_traffic_light")
def freeze_traffic_light(session: Session, actor_id: int, freeze: bool) -> None:
    light = session.light(actor_id, "freeze_traffic_light")
    session.world.signals.freeze(freeze, light.index)


@methods.void("freeze_all_traffic_lights")
def freeze_all_traffic_lights(session: Session, freeze: bool) -> None:
    session.world.signals.freeze(freeze)


@methods.void("reset_traffic_light_group")
def reset_traffic_light_group(session: Session, actor_id: int) -> None:
    light = session.light(actor_id, "reset_traffic_light_group")
    signals = session.world.signals
    signals.reset([int(signals.lights.group[light.index])])


@methods.void("reset_all_traffic_lights")
def reset_all_traffic_lights(session: Session) -> None:
    signals = session.world.signals
    signals.reset(range(len(signals.groups)))


@methods.value("get_group_traffic_lights")
def get_group_traffic_lights(session: Session, actor_id: int) -> list[int]:
    light = session.light(actor_id, "get_group_traffic_lights")
    signals = session.world.signals
    rows = signals.lights.row[signals.members(light.index)]
    ids: list[int] = session.world.bodies.record["id"][rows].tolist()
    return ids


@methods.value("get_light_boxes")
def get_light_boxes(session: Session, actor_id: int) -> Any:
    """Boxes of the lamps in the world; the lamps have no shape of their own here."""
    light = session.light(actor_id, "get_light_boxes")
    pose = session.world.pose(light)
    return [encode.box(light.box._replace(center=pose.apply(light.box.center), rotation=pose.rotation))]
