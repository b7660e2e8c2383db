"""Traffic lights on the route: where their stop lines are, and which one asks to stop now."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import carla

from stucksolver.stacks.driver.path import Path, Pose

_ON_ROUTE_M = 1.75
_SAME_DIRECTION_RAD = math.radians(60.0)
_SAME_LEVEL_M = 3.0
_PASSED_M = 1.0
_MAX_STOP_MPS2 = 5.0


class StopLine(NamedTuple):
    """Where one light stops the route: arc length of the line (m) along the route's path."""

    light: Any
    s: float


def stop_lines(lights: Sequence[Any], path: Path) -> list[StopLine]:
    """The stop lines of `carla.TrafficLight`s that lie on a route's path, in driving order.

    Places come from `TrafficLight.get_stop_waypoints`, which CARLA derives from the light's trigger volume.
    """
    found = []
    for light in lights:
        places = [_on_path(waypoint.transform, path) for waypoint in light.get_stop_waypoints()]
        met = [s for s in places if s is not None]
        if met:
            found.append(StopLine(light, min(met)))
    return sorted(found, key=lambda line: line.s)


def _on_path(transform: Any, path: Path) -> float | None:
    place = transform.location
    where = path.project(Pose(place.x, place.y, math.radians(transform.rotation.yaw)))
    beyond = not 0.0 <= where.s <= path.length
    if beyond or abs(where.lateral) > _ON_ROUTE_M or abs(where.heading) > _SAME_DIRECTION_RAD:
        return None
    x, y, _ = path.at(path.s[:1] + where.s)
    level = float(path.z[min(int(path.s.searchsorted(where.s)), len(path.z) - 1)])
    apart = math.hypot(place.x - float(x[0]), place.y - float(y[0]))
    return where.s if apart <= _ON_ROUTE_M and abs(level - place.z) < _SAME_LEVEL_M else None


class LightWatch:
    """Remembers, for one route, which light was already passed or can no longer be obeyed.

    The memory is the remedy BasicAgent and BehaviorAgent (CARLA agents, MIT) have for a car that is still in
    the trigger volume of a light it has passed.
    """

    def __init__(self, lines: Sequence[StopLine]) -> None:
        self._lines = list(lines)
        self._ids = {line.light.id for line in lines}
        self._committed: set[int] = set()

    def distance_to_stop(self, front_s: float, speed: float, deceleration: float) -> float | None:
        """Distance (m) from the front bumper at `front_s` to the line to stop at; None where there is none.

        Yellow is obeyed if `deceleration` (m/s²) is enough, red unless not even 5 m/s² is.
        """
        for line in self._lines:
            distance = line.s - front_s
            if distance < -_PASSED_M or line.light.id in self._committed:
                continue
            if self._stops(line, distance, speed, deceleration):
                return distance
        return None

    def unlisted_red(self, vehicle: Any, carla_map: Any) -> bool:
        """Is the ego, outside a junction, in the trigger volume of a red light with no line on the route?"""
        if not vehicle.is_at_traffic_light():
            return False
        light = vehicle.get_traffic_light()
        if light is None or light.id in self._ids or light.state != carla.TrafficLightState.Red:
            return False
        waypoint = carla_map.get_waypoint(vehicle.get_location())
        return waypoint is not None and not waypoint.is_junction

    def _stops(self, line: StopLine, distance: float, speed: float, deceleration: float) -> bool:
        state = line.light.state
        if state not in (carla.TrafficLightState.Red, carla.TrafficLightState.Yellow):
            return False
        enough = deceleration if state == carla.TrafficLightState.Yellow else _MAX_STOP_MPS2
        if distance > 0.0 and speed * speed <= 2.0 * enough * distance:
            return True
        if speed < 1.0:
            return True
        self._committed.add(line.light.id)
        return False
