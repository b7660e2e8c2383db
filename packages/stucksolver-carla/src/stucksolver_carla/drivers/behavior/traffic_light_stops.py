"""Traffic lights on the route: where their stop lines are, and which one requires a stop now."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import carla
import numpy as np

from stucksolver.scene.polyline import nearest_of_each_pass
from stucksolver_carla.drivers.behavior.path import Path

_ON_ROUTE_M = 1.75
_SAME_DIRECTION_COS = math.cos(math.radians(60.0))
_SAME_LINE_M = 8.0
_SAME_LEVEL_M = 3.0
_PASSED_M = 1.0
_MAX_STOP_MPS2 = 5.0
_CRAWLING_MPS = 1.0


class StopLine(NamedTuple):
    """Where one light stops the route: arc length of the line (m) along the route's path."""

    light: carla.TrafficLight
    s: float


def stop_lines(lights: Sequence[carla.TrafficLight], path: Path) -> list[StopLine]:
    """Return the stop lines of `carla.TrafficLight`s on a route's path, in driving order.

    Places come from `TrafficLight.get_stop_waypoints`, which CARLA derives from the light's trigger volume.
    """
    found: list[StopLine] = []
    for light in lights:
        places = [s for waypoint in light.get_stop_waypoints() for s in _passes(waypoint.transform, path)]
        found.extend(StopLine(light, s) for s in _one_of_each(sorted(places)))
    return sorted(found, key=lambda line: line.s)


def _passes(transform: carla.Transform, path: Path) -> list[float]:
    """Return the arc lengths at which the path passes a place in its direction; several if it passes again."""
    place, yaw = transform.location, math.radians(transform.rotation.yaw)
    distance = np.hypot(path.x - place.x, path.y - place.y)
    near = (distance < _ON_ROUTE_M) & (np.cos(path.yaw - yaw) > _SAME_DIRECTION_COS)
    near &= np.abs(path.z - place.z) < _SAME_LEVEL_M
    return [float(path.s[k]) for k in nearest_of_each_pass(near, distance)]


def _one_of_each(places: Sequence[float]) -> list[float]:
    """Return the first of every group: a light with several lanes has several places at one line."""
    return [s for i, s in enumerate(places) if i == 0 or s - places[i - 1] > _SAME_LINE_M]


class LightWatch:
    """Remembers, for one route, which lights were passed or can no longer be obeyed.

    BasicAgent and BehaviorAgent (CARLA agents, MIT) use the same memory for a car that is still in the trigger volume
    of a light it has passed.
    """

    def __init__(self, lines: Sequence[StopLine]) -> None:
        self._lines = list(lines)
        self._ids = {line.light.id for line in lines}
        self._committed: set[float] = set()

    def next_line(self, s_m: float) -> float:
        """Return the arc length of the next stop line of a light, whatever it shows (m); infinite without one."""
        return next((line.s for line in self._lines if line.s > s_m), math.inf)

    def distance_to_stop(
        self, front_s: float, speed: float, deceleration: float, released: Collection[int] = ()
    ) -> float | None:
        """Return the distance from the front bumper at `front_s` to the line to stop at (m); None if there is none.

        Yellow is obeyed if `deceleration` (m/s²) is enough, red unless even 5 m/s² is not. A light that cannot be seen
        may be red: it is obeyed like a yellow one. `released`: ids of lights that need not be obeyed.
        """
        for line in self._lines:
            distance = line.s - front_s
            if line.light.id in released:
                continue
            if distance >= -_PASSED_M and self._stops(line, distance, speed, deceleration):
                return distance
        return None

    def unlisted_red(self, vehicle: carla.Vehicle, carla_map: carla.Map) -> bool:
        """True if the ego, outside a junction, is in the trigger volume of a red light with no line on the route."""
        if not vehicle.is_at_traffic_light():
            return False
        light = vehicle.get_traffic_light()
        if light is None or light.id in self._ids or light.state != carla.TrafficLightState.Red:
            return False
        waypoint = carla_map.get_waypoint(vehicle.get_location())
        return waypoint is not None and not waypoint.is_junction

    def _stops(self, line: StopLine, distance: float, speed: float, deceleration: float) -> bool:
        if line.s in self._committed and speed > _CRAWLING_MPS:
            return False
        state = line.light.state
        if state in (carla.TrafficLightState.Green, carla.TrafficLightState.Off):
            return False
        enough = _MAX_STOP_MPS2 if state == carla.TrafficLightState.Red else deceleration
        if speed < _CRAWLING_MPS or speed * speed <= 2.0 * enough * max(distance, 0.0):
            return True
        self._committed.add(line.s)
        return False
