"""Accident."""

from __future__ import annotations

from stucksolver_eval.actors.actor_pool import lamps
from stucksolver_eval.scenarios.families.obstacle import Obstacle
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import left_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import ON_THE_RIGHT, IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

POLICE = "vehicle.dodge.charger_police_2020"
SIGN = "static.prop.warningaccident"
OFFSET = 0.6
"""Lateral offset of the cars, as a share of half the lane width."""
POLICE_GAP_M = 10.0
"""Distance between the warning sign and the police car (m)."""
CARS_GAP_M = 6.0
"""Distance between the cars (m)."""


class AccidentScene(Obstacle):
    """Base: a warning sign, a police car, and two crashed cars beyond it."""

    blueprints = (POLICE, SIGN)

    def place_obstacle(self) -> tuple[float, float]:
        self.prop(SIGN, 0.0, self.ahead(0.0).lane_width / 2.0 + 0.8, turn_deg=180.0)
        police = self.park(POLICE, self.distance_m, OFFSET)
        self.cast.lights(police, lamps("Special1", "Special2", "Position"))
        first_m = self.distance_m + POLICE_GAP_M
        self.park(self.new_car(), first_m, OFFSET)
        self.park(self.new_car(), first_m + CARS_GAP_M, OFFSET)
        return self.distance_m, first_m + CARS_GAP_M


@scenario
class Accident(AccidentScene):
    """A police car and two crashed cars block the hero's lane; it must change to the adjacent lane."""

    type = "Accident"
    placed = SuitePlacement(
        "bench220",
        1000,
        LaneSites(left_lane, 125),
        {"distance": IntegerDraw(40, 44), "direction": ON_THE_RIGHT, "speed": IntegerDraw(50, 60)},
    )
    driver_alone = "stuck behind the police car"
    starts = "the scene is present from the start; traffic in the next lane slows 5 s after the hero came within 50 m"
