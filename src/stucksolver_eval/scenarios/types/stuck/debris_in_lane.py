"""DebrisInLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.stuck import Stuck
from stucksolver_eval.scenarios.registry import scenario


@scenario
class DebrisInLane(Stuck):
    """A flat paper bag lies in the only lane: it can be driven over."""

    type = "DebrisInLane"
    expected = "recover"
    suspends = frozenset({"blocked"})
    blueprints = ("static.prop.paperbag",)

    def stage(self) -> None:
        self.put("static.prop.paperbag")
