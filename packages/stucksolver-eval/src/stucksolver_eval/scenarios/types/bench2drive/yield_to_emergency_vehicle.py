"""YieldToEmergencyVehicle."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.actors import Car
from stucksolver_eval.actors.actor_pool import lamps
from stucksolver_eval.background_traffic.lanes import slots
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.lane_places import upstream
from stucksolver_eval.scenarios.parameters import NumberParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.lane_requirements import several_lanes
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

FASTER_MPS = 25.0
"""Speed of the vehicle relative to the hero (m/s)."""
NEAR_M = 50.0
"""Distance to the hero from which the vehicle is near (m)."""
NEAR_S = 10.0
"""Time near the hero after which the scenario ends (s)."""
PASSED_M = 50.0
"""Distance ahead of the hero at which the vehicle has passed (m)."""
TAIL_GAP_M = 6.0
"""Gap of the vehicle to the vehicle ahead (m)."""
CLOSING_PER_S = 0.7
"""Gain of the closing speed (1/s)."""


@scenario
class YieldToEmergencyVehicle(Scenario):
    """An emergency vehicle approaches fast from behind; the hero must change lanes and let it pass."""

    type = "YieldToEmergencyVehicle"
    placed = SuitePlacement(
        "bench220", 1430, LaneSites(several_lanes, 180, before_m=45, direct=False), {"distance": IntegerDraw(26, 30)}
    )
    driver_alone = "completed, but does not let the vehicle pass"
    timeout_s = None
    starts = "the vehicle comes at the trigger"
    needs_map = "a second driving lane of the hero's direction"
    simplified = "the vehicle's speed is set in every tick from its distance to the vehicle ahead in its lane"
    distance_m = NumberParameter("distance", 140.0, "m")

    def needs(self, setting: ScenarioContext) -> str | None:
        if not setting.cast.kinds(special_type="emergency"):
            return "the blueprint library has no emergency vehicle"
        if len(slots(self.ahead(0.0))) < 2:
            return "at the trigger point there is no second lane to change into"
        return None

    def stage(self) -> None:
        self._vehicle = self.cast.keep_below(self.random.choice(self.cast.kinds(special_type="emergency")))

    def script(self) -> Iterator[None]:
        self.traffic.switch_route_sources(False)
        self.traffic.remove_behind()
        start = upstream(self.ahead(0.0), self.distance_m)
        self.cast.bring(self._vehicle, start.transform)
        self.cast.lights(self._vehicle, lamps("Special1", "Special2"))
        yield
        car = self.cars.drive(self._vehicle, start, self.hero.speed_mps, constant=True)
        near_since_s: float | None = None
        while not self._is_over(car, near_since_s):
            self.cars.slow(car, self._speed(car))
            if near_since_s is None and car.state.distance_m(self.hero.x, self.hero.y) < NEAR_M:
                near_since_s = self.cast.time_s
            yield
        ahead_m = car.state.ahead_m(self.hero.x, self.hero.y)
        text = "the hero did not let the emergency vehicle pass" if ahead_m > 0 else "the hero let it pass"
        self.news.append(("yield_emergency_vehicle", text, 0.0 if ahead_m > 0 else 1.0))
        self.cars.remove([car])
        self.traffic.switch_route_sources(True)

    def _speed(self, car: Car) -> float:
        """Return a speed (m/s) much higher than the hero's, limited by the gap to the vehicle ahead."""
        self.cars.find_leaders([car])
        wanted = self.hero.speed_mps + FASTER_MPS
        if car.leader is not None:
            wanted = min(wanted, car.leader.speed_mps + CLOSING_PER_S * (car.leader.gap_m - TAIL_GAP_M))
        return max(wanted, 0.0)

    def _is_over(self, car: Car, near_since_s: float | None) -> bool:
        passed = car.state.ahead_m(self.hero.x, self.hero.y) < -PASSED_M
        waited = near_since_s is not None and self.cast.time_s - near_since_s > NEAR_S
        return passed or waited or self.at_route_end()
