"""Running a red light (RunningRedLightTest)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import carla

from stucksolver_eval.criteria.criterion import Criterion, EgoTick, place_text

NEAR_M = 15.0
"""Distance within which a light is checked (m). As in RunningRedLightTest."""
STEP_M = 0.5
"""Step of the search for the stop line (m). As in RunningRedLightTest."""
LINE_PER_WIDTH = 0.6
"""Half length of the stop line as a share of the lane's width. As in RunningRedLightTest."""
TAIL_NEAR = 0.8
"""Front end of the checked rear segment, as a share of the ego's half length. As in RunningRedLightTest."""
TAIL_BEHIND_M = 1.0
"""Length of the checked segment behind the ego (m). As in RunningRedLightTest."""
Point = tuple[float, float]


class LightStopLine(NamedTuple):
    """The end of one lane at a light: its lane, heading (unit vector) and the line across it."""

    road_id: int
    lane_id: int
    heading: Point
    left: Point
    right: Point


class WatchedLight(NamedTuple):
    actor: carla.TrafficLight
    center: Any
    lines: tuple[LightStopLine, ...]


class RedLights(Criterion):
    """Reports a red light if the rear of the ego crosses its stop line."""

    kind = "red_light"

    def __init__(self, world: carla.World, carla_map: carla.Map, ego: carla.Vehicle) -> None:
        super().__init__()
        self._map = carla_map
        self._half_length = float(ego.bounding_box.extent.x)
        lights = world.get_actors().filter("*traffic_light*")
        self._lights = [_light(carla_map, actor) for actor in sorted(lights, key=lambda a: a.id)]
        self._last_id: int | None = None

    def update(self, moment: EgoTick) -> None:
        if self.kind in moment.suspended:
            return
        near = [light for light in self._lights if light.center.distance(moment.location) <= NEAR_M]
        for light in near:
            if light.actor.id != self._last_id and light.actor.state == carla.TrafficLightState.Red:
                self._check(light, moment)

    def _check(self, light: WatchedLight, moment: EgoTick) -> None:
        close = _behind(moment, TAIL_NEAR * self._half_length)
        far = _behind(moment, self._half_length + TAIL_BEHIND_M)
        lane = self._map.get_waypoint(carla.Location(far[0], far[1], moment.location.z))
        ahead = moment.transform.get_forward_vector()
        for line in light.lines:
            same = lane is not None and (lane.road_id, lane.lane_id) == (line.road_id, line.lane_id)
            agree = ahead.x * line.heading[0] + ahead.y * line.heading[1] > 0.0
            if same and agree and crosses((close, far), (line.left, line.right)):
                self._last_id = light.actor.id
                where = place_text(light.actor.get_location())
                self.note(moment.time_s, f"ran red light {light.actor.id} at {where}")
                return


def crosses(a: tuple[Point, Point], b: tuple[Point, Point]) -> bool:
    """True if two segments meet."""
    return _sides(a, b) and _sides(b, a)


def _sides(a: tuple[Point, Point], b: tuple[Point, Point]) -> bool:
    """True if the ends of `b` lie on different sides of `a`'s line, or on it."""
    (x, y), (u, v) = a
    first, second = ((u - x) * (q - y) - (v - y) * (p - x) for p, q in b)
    return first * second <= 0.0


def _behind(moment: EgoTick, distance_m: float) -> Point:
    """Return a point behind the ego's center."""
    yaw = math.radians(moment.transform.rotation.yaw)
    place = moment.location
    return place.x - distance_m * math.cos(yaw), place.y - distance_m * math.sin(yaw)


def _light(carla_map: carla.Map, actor: carla.TrafficLight) -> WatchedLight:
    volume, base = actor.trigger_volume, actor.get_transform()
    center = base.transform(carla.Location(volume.location))
    yaw = math.radians(base.rotation.yaw + volume.rotation.yaw)
    reach = float(volume.extent.x)
    offsets = [-0.9 * reach + k for k in range(int(1.8 * reach) + 1)]
    lanes: list[Any] = []
    for offset in offsets:
        at = carla.Location(center.x + offset * math.cos(yaw), center.y + offset * math.sin(yaw), center.z)
        lane = carla_map.get_waypoint(at)
        if lane is not None and (not lanes or _key(lanes[-1]) != _key(lane)):
            lanes.append(lane)
    return WatchedLight(actor, center, tuple(_stop_line(_before_junction(lane)) for lane in lanes))


def _key(waypoint: carla.Waypoint) -> tuple[int, int]:
    return int(waypoint.road_id), int(waypoint.lane_id)


def _before_junction(waypoint: carla.Waypoint) -> carla.Waypoint:
    """Return the last waypoint before the junction ahead, in steps of half a meter."""
    while not waypoint.is_junction:
        following = waypoint.next(STEP_M)
        if not following or following[0].is_junction:
            break
        waypoint = following[0]
    return waypoint


def _stop_line(waypoint: carla.Waypoint) -> LightStopLine:
    place = waypoint.transform.location
    ahead = waypoint.transform.get_forward_vector()
    reach = LINE_PER_WIDTH * float(waypoint.lane_width)
    aside = (-ahead.y * reach, ahead.x * reach)
    return LightStopLine(
        road_id=int(waypoint.road_id),
        lane_id=int(waypoint.lane_id),
        heading=(ahead.x, ahead.y),
        left=(place.x - aside[0], place.y - aside[1]),
        right=(place.x + aside[0], place.y + aside[1]),
    )
