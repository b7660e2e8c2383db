"""Traffic lights and stop signs along the route, in the solver's form."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import carla

from stucksolver.scene import ControlKind, LightState, TrafficControl
from stucksolver_carla.drivers.behavior.stop_signs import stop_places
from stucksolver_carla.stack.route_road import RouteRoad

_STATES = {
    carla.TrafficLightState.Red: LightState.RED,
    carla.TrafficLightState.Yellow: LightState.YELLOW,
    carla.TrafficLightState.Green: LightState.GREEN,
    carla.TrafficLightState.Off: LightState.OFF,
}
AHEAD_M = 120.0
PASSED_M = 3.0
NEAR_M = 20.0


class RouteTrafficControls:
    """The stop lines of lights and the stop signs on a route; found once, read on demand."""

    def __init__(
        self, lights: Sequence[carla.TrafficLight], road: RouteRoad, signs: Sequence[carla.TrafficSign] = ()
    ) -> None:
        self._lines: list[tuple[float, Any]] = []
        for light in lights:
            crossings = [road.crossing(w.transform) for w in light.get_stop_waypoints()]
            stop_arcs = [arc for arc in crossings if arc is not None]
            if stop_arcs:
                self._lines.append((min(stop_arcs), light))
        self._lines.sort(key=lambda line: line[0])
        self._signs = stop_places(signs, *road.fine_line()) if signs else []

    def lights_near(self, front_arc_m: float) -> frozenset[int]:
        """Return the ids of the lights whose line is close ahead, and which a plan may creep across."""
        return frozenset(int(light.id) for arc, light in self._lines if -PASSED_M < arc - front_arc_m < NEAR_M)

    def ahead(self, front_arc_m: float) -> tuple[TrafficControl, ...]:
        """Return the lights and signs from a little behind the front bumper to 120 m ahead of it."""
        lights = [
            TrafficControl(
                kind=ControlKind.TRAFFIC_LIGHT,
                distance_m=round(arc - front_arc_m, 2),
                applies=True,
                state=_STATES.get(light.get_state(), LightState.UNKNOWN),
            )
            for arc, light in self._lines
            if -PASSED_M < arc - front_arc_m < AHEAD_M
        ]
        signs = [
            TrafficControl(kind=ControlKind.STOP_SIGN, distance_m=round(arc - front_arc_m, 2), applies=True)
            for arc in self._signs
            if -PASSED_M < arc - front_arc_m < AHEAD_M
        ]
        return tuple(sorted(lights + signs, key=lambda control: control.distance_m))
