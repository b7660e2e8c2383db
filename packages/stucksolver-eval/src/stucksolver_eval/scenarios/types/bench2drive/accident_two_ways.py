"""AccidentTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.obstacle import TwoWays
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.bench2drive.accident import AccidentScene
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import Along
from stucksolver_eval.sites.parameter_draws import IntervalDraw, Value
from stucksolver_eval.sites.suite_placement import Placed


@scenario
class AccidentTwoWays(TwoWays, AccidentScene):
    """A police car and two crashed cars block the only lane; the hero must use a gap of the oncoming flow."""

    type = "AccidentTwoWays"
    placed = Placed(
        "bench220",
        1010,
        Along(two_ways, 150),
        {"distance": Value(40, 45), "frequency": IntervalDraw((30, 63), (108, 190))},
    )
    driver_alone = "stuck behind the police car"
    starts = "the scene is present from the start; the oncoming flow starts 5 s after the hero came within 50 m"
