"""ConstructionObstacle."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.obstacle import ConstructionSite
from stucksolver_eval.scenarios.parameters import NumberParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import left_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import ON_THE_RIGHT, IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class ConstructionObstacle(ConstructionSite):
    """A construction site with cones closes the hero's lane; it must change to the adjacent lane."""

    type = "ConstructionObstacle"
    placed = SuitePlacement(
        "bench220",
        1030,
        LaneSites(left_lane, 125),
        {"distance": IntegerDraw(40, 45), "direction": ON_THE_RIGHT, "speed": IntegerDraw(44, 58)},
    )
    driver_alone = "stuck before the cones"
    starts = "the site appears at the trigger; traffic in the next lane slows 5 s after the hero came within 30 m"
    distance_m = NumberParameter("distance", 100.0, "m")
