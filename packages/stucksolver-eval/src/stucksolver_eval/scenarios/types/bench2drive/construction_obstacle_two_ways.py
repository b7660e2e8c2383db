"""ConstructionObstacleTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.obstacle import ConstructionSite, TwoWayObstacle
from stucksolver_eval.scenarios.parameters import NumberParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw, IntervalDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class ConstructionObstacleTwoWays(ConstructionSite, TwoWayObstacle):
    """A construction site with cones closes the only lane; the hero must use a gap of the oncoming flow."""

    type = "ConstructionObstacleTwoWays"
    placed = SuitePlacement(
        "bench220",
        1040,
        LaneSites(two_ways, 150),
        {"distance": IntegerDraw(40, 45), "frequency": IntervalDraw((40, 75), (111, 200))},
    )
    driver_alone = "stuck before the cones"
    starts = "the site appears at the trigger; the oncoming flow starts 5 s after the hero came within 30 m"
    needs_map = TwoWayObstacle.needs_map
    distance_m = NumberParameter("distance", 100.0, "m")
