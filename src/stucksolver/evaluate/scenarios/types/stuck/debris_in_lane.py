"""DebrisInLane."""

from __future__ import annotations

from stucksolver.evaluate.scenarios.moves.stuck import Stuck
from stucksolver.evaluate.scenarios.registry import scenario


@scenario
class DebrisInLane(Stuck):
    """A flat paper bag lies in the only lane: it can be driven over."""

    type = "DebrisInLane"
    expected = "recover"
    suspends = frozenset({"blocked"})
    blueprints = ("static.prop.paperbag",)

    def stage(self) -> None:
        self.put("static.prop.paperbag")
