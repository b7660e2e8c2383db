"""ParkedObstacleTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.actions.obstacle import TwoWays
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.parked_obstacle import ParkedCar
from stucksolver_eval.sites.along import Along
from stucksolver_eval.sites.fits import two_ways
from stucksolver_eval.sites.placed import Placed
from stucksolver_eval.sites.values import IntervalDraw, Value


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
