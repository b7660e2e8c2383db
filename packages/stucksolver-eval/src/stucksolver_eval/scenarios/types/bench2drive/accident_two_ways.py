"""AccidentTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.obstacle import TwoWayObstacle
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.bench2drive.accident import AccidentScene
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw, IntervalDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class AccidentTwoWays(TwoWayObstacle, AccidentScene):
    """A police car and two crashed cars block the only lane; the hero must use a gap of the oncoming flow."""

    type = "AccidentTwoWays"
    placed = SuitePlacement(
        "bench220",
        1010,
        LaneSites(two_ways, 150),
        {"distance": IntegerDraw(40, 45), "frequency": IntervalDraw((30, 63), (108, 190))},
    )
    driver_alone = "stuck behind the police car"
    starts = "the scene is present from the start; the oncoming flow starts 5 s after the hero came within 50 m"
