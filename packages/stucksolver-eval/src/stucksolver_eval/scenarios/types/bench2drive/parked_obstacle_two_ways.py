"""ParkedObstacleTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.obstacle import TwoWays
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.bench2drive.parked_obstacle import ParkedCar
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import Along
from stucksolver_eval.sites.parameter_draws import IntervalDraw, Value
from stucksolver_eval.sites.suite_placement import Placed


@scenario
class ParkedObstacleTwoWays(TwoWays, ParkedCar):
    """A car with hazard lights stands in the only lane; the hero must use a gap of the oncoming flow."""

    type = "ParkedObstacleTwoWays"
    placed = Placed(
        "bench220",
        1250,
        Along(two_ways, 150),
        {"distance": Value(40, 45), "frequency": IntervalDraw((31, 61), (106, 200))},
    )
    driver_alone = "stuck behind the car"
    starts = "the car stands there from the start; the oncoming flow starts 5 s after the hero came within 50 m"
