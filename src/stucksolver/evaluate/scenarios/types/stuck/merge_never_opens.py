"""MergeNeverOpens."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver.evaluate.scenarios.moves.actor_flow import ActorFlow
from stucksolver.evaluate.scenarios.moves.flow import Flow, run_flows
from stucksolver.evaluate.scenarios.registry import scenario

SPEED_MPS, GAPS_M = 5.0, (11.0, 13.0)


@scenario
class MergeNeverOpens(ActorFlow):
    """The lane that the hero has to merge into is dense and slow, and no gap comes; drivers brake for who noses in."""

    type = "MergeNeverOpens"
    expected = "recover"
    timeout_s = None
    suspends = frozenset({"blocked"})
    needs_map = "lanes from `start_actor_flow` to `end_actor_flow`"
    all_lanes = False

    def script(self) -> Iterator[None]:
        self.clear_way()
        flow = Flow(self, self.lines()[0], SPEED_MPS, GAPS_M, constant=False)
        flow.fill()
        yield from run_flows([flow], self.over())
        self.restore_way()
