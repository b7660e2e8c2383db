"""Finds the stop lines of traffic lights on the route, and the one that requires a stop now."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import carla
import numpy as np

from stucksolver.scene.polyline import nearest_of_each_pass
from stucksolver_carla.drivers.behavior.path import Path

_ON_ROUTE_M = 1.75
"""Maximum distance from the path to a stop waypoint of the route's lane (m): half a lane."""
_SAME_DIRECTION_COS = math.cos(math.radians(60.0))
"""Cosine of the maximum angle between the path and a stop waypoint. Ours."""
_SAME_LINE_M = 8.0
"""Distance below which two stop waypoints of a light belong to one stop line (m). Ours."""
_SAME_LEVEL_M = 3.0
"""Maximum height difference between the path and a stop waypoint (m). Ours."""
_PASSED_M = 1.0
"""Distance behind the front bumper from which a stop line counts as passed (m). Ours."""
_MAX_STOP_MPS2 = 5.0
"""Deceleration up to which the ego stops for a red light (m/s²). Ours."""
_CRAWLING_MPS = 1.0
"""Speed below which the ego can always stop (m/s). Ours."""


class StopLine(NamedTuple):
    """The stop line of one light: its arc length along the route's path (m)."""

    light: carla.TrafficLight
    s: float


def stop_lines(lights: Sequence[carla.TrafficLight], path: Path) -> list[StopLine]:
    """Return the stop lines of `carla.TrafficLight`s on a route's path, in driving order.

    Positions come from `TrafficLight.get_stop_waypoints`, which CARLA derives from the light's trigger volume.
    """
    lines: list[StopLine] = []
    for light in lights:
        arc_lengths_m = [s for waypoint in light.get_stop_waypoints() for s in _passes(waypoint.transform, path)]
        lines.extend(StopLine(light, s) for s in _first_of_groups(sorted(arc_lengths_m)))
    return sorted(lines, key=lambda line: line.s)


def _passes(transform: carla.Transform, path: Path) -> list[float]:
    """Return the arc lengths at which the path passes a waypoint in its direction; several for repeated passes."""
    location, yaw = transform.location, math.radians(transform.rotation.yaw)
    distance = np.hypot(path.x - location.x, path.y - location.y)
    is_near = (distance < _ON_ROUTE_M) & (np.cos(path.yaw - yaw) > _SAME_DIRECTION_COS)
    is_near &= np.abs(path.z - location.z) < _SAME_LEVEL_M
    return [float(path.s[k]) for k in nearest_of_each_pass(is_near, distance)]


def _first_of_groups(arc_lengths_m: Sequence[float]) -> list[float]:
    """Return the first arc length of every group, because a light has a waypoint for each lane of its stop line."""
    return [s for i, s in enumerate(arc_lengths_m) if i == 0 or s - arc_lengths_m[i - 1] > _SAME_LINE_M]


class LightWatch:
    """The stop lines of one route, with those at which the ego can no longer stop.

    BasicAgent and BehaviorAgent (CARLA agents, MIT) use the same memory for a car that is still in the trigger volume
    of a light behind it.
    """

    def __init__(self, lines: Sequence[StopLine]) -> None:
        self._lines = list(lines)
        self._ids = {line.light.id for line in lines}
        self._committed: set[float] = set()

    def next_line(self, s_m: float) -> float:
        """Return the arc length of the next stop line, for any state of its light (m); infinity without one."""
        return next((line.s for line in self._lines if line.s > s_m), math.inf)

    def distance_to_stop(
        self, front_s: float, speed: float, deceleration: float, ignored_ids: Collection[int] = ()
    ) -> float | None:
        """Return the distance from the front bumper at `front_s` to the next required stop (m); None without one.

        The ego stops for yellow if `deceleration` (m/s²) suffices, and for red if 5 m/s² suffices. A light of unknown
        state may be red and counts as yellow. `ignored_ids`: ids of lights that require no stop.
        """
        for line in self._lines:
            distance = line.s - front_s
            if line.light.id in ignored_ids:
                continue
            if distance >= -_PASSED_M and self._must_stop(line, distance, speed, deceleration):
                return distance
        return None

    def unlisted_red(self, vehicle: carla.Vehicle, carla_map: carla.Map) -> bool:
        """Return True in the trigger volume of a red light without a line on the route, outside junctions."""
        if not vehicle.is_at_traffic_light():
            return False
        light = vehicle.get_traffic_light()
        if light is None or light.id in self._ids or light.state != carla.TrafficLightState.Red:
            return False
        waypoint = carla_map.get_waypoint(vehicle.get_location())
        return waypoint is not None and not waypoint.is_junction

    def _must_stop(self, line: StopLine, distance: float, speed: float, deceleration: float) -> bool:
        if line.s in self._committed and speed > _CRAWLING_MPS:
            return False
        state = line.light.state
        if state in (carla.TrafficLightState.Green, carla.TrafficLightState.Off):
            return False
        deceleration_mps2 = _MAX_STOP_MPS2 if state == carla.TrafficLightState.Red else deceleration
        if speed < _CRAWLING_MPS or speed * speed <= 2.0 * deceleration_mps2 * max(distance, 0.0):
            return True
        self._committed.add(line.s)
        return False
