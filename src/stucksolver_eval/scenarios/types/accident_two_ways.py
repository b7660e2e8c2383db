"""AccidentTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.actions.obstacle import TwoWays
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.accident import AccidentScene
from stucksolver_eval.sites.along import Along
from stucksolver_eval.sites.fits import two_ways
from stucksolver_eval.sites.placed import Placed
from stucksolver_eval.sites.values import IntervalDraw, Value


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
