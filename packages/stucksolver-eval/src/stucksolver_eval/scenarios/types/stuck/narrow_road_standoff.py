"""NarrowRoadStandoff."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import carla

from stucksolver_bridge.traffic_side import inner_lane
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.lane_places import run_of_lane
from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import narrow
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

SPEED_MPS = 4.0
"""Speed of the oncoming car (m/s)."""
FROM_M = 30.0
"""Distance beyond the situation at which the car starts (m)."""
BACKED_M = 6.0
"""Distance that the hero must back up (m)."""


@scenario
class NarrowRoadStandoff(StuckScenario):
    """On a road too narrow for two, an oncoming car stops before the hero; it leaves when the hero has backed up."""

    type = "NarrowRoadStandoff"
    placed = SuitePlacement("immobilized", 3050, LaneSites(narrow), {"distance": IntegerDraw(40, 48)})
    driver_alone = "stuck nose to nose"
    expected = "recover"
    suspends = frozenset({"blocked", "wrong_lane"})
    starts = "the car comes from the trigger on"
    needs_map = "an oncoming lane next to the hero's"
    simplified = "when the hero has backed up 6 m, the other car disappears, as if into a driveway"

    def needs(self, setting: ScenarioContext) -> str | None:
        if self._oncoming(self.distance_m) is None:
            return f"{self.distance_m:.0f} m beyond the trigger point there is no adjacent oncoming lane"
        return None

    def _oncoming(self, distance_m: float) -> Any | None:
        """Return the adjacent oncoming lane of any width, or None."""
        here = self.ahead(distance_m)
        lane = inner_lane(here)
        against = lane is not None and lane.lane_type == carla.LaneType.Driving and lane.lane_id * here.lane_id < 0
        return lane if against else None

    def situation(self) -> Iterator[None]:
        self.traffic.change_opposite_behavior(active=False)
        self.traffic.clear_opposite()
        self.traffic.remove_behind()
        self.traffic.switch_route_sources(False)
        lane = self._oncoming(self.distance_m + FROM_M)
        assert lane is not None
        member = self.cast.must_spawn("vehicle.lincoln.mkz_2020", lane.transform)
        # It drives in the middle of the road, so that neither can pass the other.
        car = self.cars.drive(member, run_of_lane(lane, 200.0), SPEED_MPS, offset_m=-lane.lane_width / 2.0)
        # The hero's position on the route never decreases, so it does not reflect backing up.
        foremost = self.hero
        while (backed_m := self.hero.ahead_m(foremost.x, foremost.y)) < BACKED_M and not self.at_route_end():
            foremost = self.hero if backed_m < 0.0 else foremost
            yield
        self.cars.remove([car])
