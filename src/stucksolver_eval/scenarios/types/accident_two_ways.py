"""AccidentTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.obstacle import TwoWays
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.accident import AccidentScene


@scenario
class AccidentTwoWays(TwoWays, AccidentScene):
    """A police car and two crashed cars block the only lane; the hero must use a gap of the oncoming flow."""

    type = "AccidentTwoWays"
    starts = "the scene stands from the start; the oncoming flow begins 5 s after the hero came within 50 m"
