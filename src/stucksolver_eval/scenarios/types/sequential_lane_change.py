"""SequentialLaneChange."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.base import Scenario
from stucksolver_eval.scenarios.registry import scenario

LENGTH_M = 200.0


@scenario
class SequentialLaneChange(Scenario):
    """The route asks for several lane changes one after the other, in the traffic that is there."""

    type = "SequentialLaneChange"
    starts = "nothing happens; the route itself is the task"

    def script(self) -> Iterator[None]:
        yield from self.until_passed(self.trigger_s_m + LENGTH_M)
