"""SequentialLaneChange."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.motorway_sites import lane_changes
from stucksolver_eval.sites.suite_placement import SuitePlacement

LENGTH_M = 200.0
"""Distance beyond the trigger at which the scenario ends (m)."""


@scenario
class SequentialLaneChange(Scenario):
    """The route requires several lane changes one after another, in background traffic."""

    type = "SequentialLaneChange"
    placed = SuitePlacement("bench220", 1300, lane_changes)
    driver_alone = "completed"
    starts = "nothing happens; the route itself is the task"

    def script(self) -> Iterator[None]:
        yield from self.until_passed(self.trigger_s_m + LENGTH_M)
