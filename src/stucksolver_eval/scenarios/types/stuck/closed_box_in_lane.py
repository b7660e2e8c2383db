"""ClosedBoxInLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.stuck import PASSABLE_M, Stuck
from stucksolver_eval.scenarios.registry import scenario


@scenario
class ClosedBoxInLane(Stuck):
    """A closed box lies in the only lane, and nobody knows what is in it: go round it, never over it."""

    type = "ClosedBoxInLane"
    expected = "recover"
    suspends = frozenset({"blocked", "wrong_lane"})
    oncoming_gaps_m = PASSABLE_M
    needs_map = "one lane each way"
    blueprints = ("static.prop.cardboardbox",)

    def stage(self) -> None:
        self.put("static.prop.cardboardbox")
