"""StuckRedLight."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.families.stuck import StuckAtLight
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import ALL_WAYS, LIT, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class StuckRedLight(StuckAtLight):
    """The hero is first at a light that stays red forever: only a remote operator may approve a crossing, so ask.

    The rules wait at a red light for three minutes. The limit on ticks would leave hardly any time to call for help
    after that, so it is suspended.
    """

    type = "StuckRedLight"
    placed = SuitePlacement("immobilized", 3080, JunctionSites(ALL_WAYS, LIT))
    driver_alone = "stuck at the light, which is right, but requests no assistance"
    expected = "ask"
    suspends = frozenset({"blocked", "tick_runtime"})

    def situation(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario(stop_entries=False)
        self.hold_lights(green=[])
        yield
