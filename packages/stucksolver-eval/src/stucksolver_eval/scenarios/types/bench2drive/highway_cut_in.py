"""HighwayCutIn."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import carla

from stucksolver_eval.actors import Car
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.lane_places import run_of_lane, side_driving_lane
from stucksolver_eval.scenarios.parameters import LocationParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario, ScenarioError
from stucksolver_eval.sites.motorway_sites import cut_ins
from stucksolver_eval.sites.suite_placement import SuitePlacement

SLOWEST_MPS = 4.0
"""Lowest speed of the vehicle (m/s)."""
FASTEST_MPS = 30.0
"""Highest speed of the vehicle (m/s)."""
SHARE = 0.8
"""Speed after the cut-in, as a share of the hero's."""
FOLLOW_S = 0.3
"""Time from the arrival to the lane change (s)."""
CHANGE_S = 2.0
"""Duration of the lane change (s)."""
AFTER_S = 3.0
"""Time after the lane change at which the scenario ends (s)."""
LIMIT_S = 60.0
"""Time limit of the arrival (s)."""
LOOK_M = 300.0
"""Length of ramp that is searched (m)."""


@scenario
class HighwayCutIn(Scenario):
    """A vehicle comes from a ramp next to the hero and cuts into its lane, slower than the hero."""

    type = "HighwayCutIn"
    placed = SuitePlacement("bench220", 1120, cut_ins)
    driver_alone = "completed: brakes, a near miss"
    timeout_s = None
    starts = "the vehicle starts at the trigger, timed to arrive with the hero"
    needs_map = "a lane from `other_actor_location` into a junction with the hero's road"
    simplified = "the vehicle's speed is updated ten times a second until it has arrived"
    start_at = LocationParameter("other_actor_location", None)

    def needs(self, setting: ScenarioContext) -> str | None:
        line = self._line()
        if not any(w.is_junction for w in line) or line[-1].is_junction:
            return "the lane at <other_actor_location> does not lead through a junction"
        if not self._is_heros(line[-1]) and side_driving_lane(line[-1], "left") is None:
            return "there is no lane to cut into at the end of the ramp"
        return None

    def _line(self) -> list[Any]:
        """Return waypoints from the vehicle's start to the first one after the junction. Raises `ScenarioError`."""
        if self.start_at is None:
            raise ScenarioError(f'{self.spec.name}: write <other_actor_location x="..." y="..." z="..."/>')
        start = self.setting.map.get_waypoint(carla.Location(*self.start_at))
        line = run_of_lane(start, LOOK_M)
        first = next((k for k, w in enumerate(line) if w.is_junction), len(line))
        after = next((k for k in range(first, len(line)) if not line[k].is_junction), len(line) - 1)
        return line[: after + 1]

    def _is_heros(self, waypoint: carla.Waypoint) -> bool:
        """Return True if the waypoint is in the hero's lane."""
        route = self.setting.route
        place = waypoint.transform.location
        there = route.waypoints[route.project(place, self.trigger_index)].transform.location
        return bool(there.distance(place) < waypoint.lane_width / 2.0)

    def stage(self) -> None:
        self._vehicle = self.cast.keep_below(self.cast.some_car(self.random))

    def script(self) -> Iterator[None]:
        line = self._line()
        route = self.setting.route
        meet_s = float(route.s_m[route.project(line[-1].transform.location, self.trigger_index)])
        self.traffic.handle_junction_scenario(remove_entries=[line[0]])
        self.cast.bring(self._vehicle, line[0].transform)
        yield
        car = self.cars.drive(self._vehicle, line, self.limit_mps, constant=True)
        end_s = self.cast.time_s + LIMIT_S
        length_m = car.path.s[len(line) - 1] if len(car.path.s) >= len(line) else car.path.s[-1]
        yield from self._arrive(car, meet_s, length_m, end_s)
        yield from self.wait(FOLLOW_S)
        yield from self._cut_in(car)
        self.cars.remove([car])

    def _arrive(self, car: Car, meet_s: float, length_m: float, end_s: float) -> Iterator[None]:
        """Script: keep the car's time to the end of the ramp equal to the hero's."""
        ticks = 0
        while car.s < length_m and self.cast.time_s < end_s:
            if ticks % 2 == 0:
                seconds = max(self.gap_m(meet_s), 0.5) / max(self.hero.speed_mps, 0.5)
                self.cars.slow(car, min(max((length_m - car.s) / seconds, SLOWEST_MPS), FASTEST_MPS))
            ticks += 1
            yield

    def _cut_in(self, car: Car) -> Iterator[None]:
        speed = max(SHARE * self.hero.speed_mps, SLOWEST_MPS)
        self.cars.slow(car, speed)
        here = self.setting.map.get_waypoint(carla.Location(car.state.x, car.state.y, car.state.z))
        onto = side_driving_lane(here, "left")
        # On a ramp that leads straight into the hero's lane, the car has already cut in.
        if onto is not None and not self._is_heros(here):
            self.cars.change_lane(car, onto, CHANGE_S * speed)
        yield from self.wait(CHANGE_S + AFTER_S)
