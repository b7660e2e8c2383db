"""DisabledCarAndPaperBag."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.lane_places import side_driving_lane
from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import right_of_two
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

BEYOND_M = 13.0
"""Distance from the car to the object (m). The ego reaches the object in the left lane, and cannot return before it."""


class DisabledCarAndThing(StuckScenario):
    """Base: a disabled car in the right lane, and an object in the left lane a little farther on."""

    needs_map = "a second driving lane on the left"
    suspends = frozenset({"blocked"})
    thing: ClassVar[str]

    def needs(self, setting: ScenarioContext) -> str | None:
        if side_driving_lane(self.ahead(self.distance_m), "left") is None:
            return f"{self.distance_m:.0f} m beyond the trigger point there is no driving lane on the left"
        return None

    def stage(self) -> None:
        lane = self.ahead(self.distance_m)
        self.put_disabled("vehicle.lincoln.mkz_2020")
        self.spawn_at(self.thing, BEYOND_M, -lane.lane_width)

    def situation(self) -> Iterator[None]:
        # Traffic in that lane would reveal whether the object can be driven over.
        lane = side_driving_lane(self.ahead(self.distance_m), "left")
        assert lane is not None, "needs() was called"
        self.traffic.remove_road_lane(lane)
        yield


@scenario
class DisabledCarAndPaperBag(DisabledCarAndThing):
    """A disabled car blocks the right lane, and a paper bag lies in the left: change lanes, drive over it, return."""

    type = "DisabledCarAndPaperBag"
    placed = SuitePlacement("immobilized", 3000, LaneSites(right_of_two), {"distance": IntegerDraw(40, 48)})
    driver_alone = "stuck behind the car"
    expected = "recover"
    thing = "static.prop.paperbag"
    blueprints = (thing,)
