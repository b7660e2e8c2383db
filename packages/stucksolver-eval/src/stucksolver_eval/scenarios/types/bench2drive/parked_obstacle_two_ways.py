"""ParkedObstacleTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.obstacle import TwoWayObstacle
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.bench2drive.parked_obstacle import ParkedCar
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw, IntervalDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class ParkedObstacleTwoWays(TwoWayObstacle, ParkedCar):
    """A car with hazard lights is stopped in the only lane; the hero must use a gap of the oncoming flow."""

    type = "ParkedObstacleTwoWays"
    placed = SuitePlacement(
        "bench220",
        1250,
        LaneSites(two_ways, 150),
        {"distance": IntegerDraw(40, 45), "frequency": IntervalDraw((31, 61), (106, 200))},
    )
    driver_alone = "stuck behind the car"
    starts = "the car is there from the start; the oncoming flow starts 5 s after the hero came within 50 m"
