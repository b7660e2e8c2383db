"""ParkedObstacle."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.obstacle import Obstacle
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import left_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import ON_THE_RIGHT, IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

OFFSET = 0.7
"""Lateral offset of the car, as a share of half the lane width."""


class ParkedCar(Obstacle):
    """Base: one car with its hazard lights on."""

    def place_obstacle(self) -> tuple[float, float]:
        car = self.park(self.new_car(), self.distance_m, OFFSET)
        self.hazard_lamps(car)
        return self.distance_m, self.distance_m


@scenario
class ParkedObstacle(ParkedCar):
    """A car with hazard lights is stopped in the hero's lane; it must change to the adjacent lane."""

    type = "ParkedObstacle"
    placed = SuitePlacement(
        "bench220",
        1240,
        LaneSites(left_lane, 125),
        {"distance": IntegerDraw(40, 44), "direction": ON_THE_RIGHT, "speed": IntegerDraw(40, 59)},
    )
    driver_alone = "stuck behind the car"
    starts = "the car is there from the start; traffic in the next lane slows 5 s after the hero came within 50 m"
