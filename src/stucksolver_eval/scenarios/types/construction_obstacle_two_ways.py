"""ConstructionObstacleTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.obstacle import ConstructionSite, TwoWays
from stucksolver_eval.scenarios.parameters import Number
from stucksolver_eval.scenarios.registry import scenario


@scenario
class ConstructionObstacleTwoWays(ConstructionSite, TwoWays):
    """A construction site with cones closes the only lane; the hero must use a gap of the oncoming flow."""

    type = "ConstructionObstacleTwoWays"
    starts = "the site rises at the trigger; the oncoming flow begins 5 s after the hero came within 30 m"
    needs_map = TwoWays.needs_map
    distance_m = Number("distance", 100.0, "m")
