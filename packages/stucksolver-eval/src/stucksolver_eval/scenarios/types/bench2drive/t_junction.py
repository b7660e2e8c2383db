"""T_Junction."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.junction_sites import TURNS, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement

LENGTH_M = 200.0
"""Distance beyond the trigger at which the scenario ends (m)."""


@scenario
class TJunction(Scenario):
    """The hero turns at a T-junction with the existing traffic, lights and signs."""

    type = "T_Junction"
    placed = SuitePlacement("bench220", 1350, JunctionSites(TURNS, arms=3))
    driver_alone = "completed: yields"
    starts = "nothing happens; lights and signs are unchanged"

    def script(self) -> Iterator[None]:
        yield from self.until_passed(self.trigger_s_m + LENGTH_M)
