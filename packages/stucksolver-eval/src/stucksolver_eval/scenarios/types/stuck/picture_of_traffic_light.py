"""PictureOfTrafficLight."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.lane_places import edge_m
from stucksolver_eval.scenarios.families.stuck import PASSABLE_M, StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways_by_sidewalk
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.stuck_sites import to_pass
from stucksolver_eval.sites.suite_placement import SuitePlacement

STOP, POSTER, CAR = "static.prop.busstoplb", "static.prop.advertisement", "vehicle.lincoln.mkz_2020"
BEFORE_M = 6.0
"""Distance of the bus stop before the car (m)."""


@scenario
class PictureOfTrafficLight(StuckScenario):
    """A bus stop shows a picture of a red traffic light, and a car ahead waits for it: it does not count, so pass."""

    type = "PictureOfTrafficLight"
    placed = SuitePlacement("immobilized", 3150, to_pass(two_ways_by_sidewalk), {"distance": IntegerDraw(40, 48)})
    driver_alone = "stuck behind the car"
    expected = "recover"
    simplified = "the picture itself is not drawn; only the absence of a light is visible"
    suspends = frozenset({"blocked", "wrong_lane"})
    oncoming_gaps_m = PASSABLE_M
    needs_map = "one lane each way and a sidewalk"
    blueprints = (STOP, POSTER, CAR)

    def stage(self) -> None:
        aside_m = edge_m(self.ahead(self.distance_m)) + 2.3
        self.spawn_at(STOP, 0.0, aside_m, turn_deg=90.0)
        self.spawn_at(POSTER, -4.5, aside_m - 1.0, turn_deg=90.0)
        self.spawn_at(CAR, -BEFORE_M)
