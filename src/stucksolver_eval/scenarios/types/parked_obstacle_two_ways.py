"""ParkedObstacleTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.obstacle import TwoWays
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.parked_obstacle import ParkedCar


@scenario
class ParkedObstacleTwoWays(TwoWays, ParkedCar):
    """A car with hazard lights stands in the only lane; the hero must use a gap of the oncoming flow."""

    type = "ParkedObstacleTwoWays"
    starts = "the car stands from the start; the oncoming flow begins 5 s after the hero came within 50 m"
