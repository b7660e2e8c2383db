"""ConstructionObstacleTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.obstacle import ConstructionSite, TwoWays
from stucksolver_eval.scenarios.parameters import Number
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import Along
from stucksolver_eval.sites.parameter_draws import IntervalDraw, Value
from stucksolver_eval.sites.suite_placement import Placed


@scenario
class ConstructionObstacleTwoWays(ConstructionSite, TwoWays):
    """A construction site with cones closes the only lane; the hero must use a gap of the oncoming flow."""

    type = "ConstructionObstacleTwoWays"
    placed = Placed(
        "bench220",
        1040,
        Along(two_ways, 150),
        {"distance": Value(40, 45), "frequency": IntervalDraw((40, 75), (111, 200))},
    )
    driver_alone = "stuck before the cones"
    starts = "the site appears at the trigger; the oncoming flow starts 5 s after the hero came within 30 m"
    needs_map = TwoWays.needs_map
    distance_m = Number("distance", 100.0, "m")
