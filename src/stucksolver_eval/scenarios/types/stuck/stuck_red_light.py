"""StuckRedLight."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.actions.stuck import StuckAtLight
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.placed import Placed
from stucksolver_eval.sites.through import ALL_WAYS, LIT, Through


@scenario
class StuckRedLight(StuckAtLight):
    """First at its light, the hero finds it red for ever: nobody but a remote operator may release it, so ask in time.

    A red light is waited for for three minutes, after which the limit on ticks leaves hardly any time to call for help.
    """

    type = "StuckRedLight"
    placed = Placed("immobilized", 3080, Through(ALL_WAYS, LIT))
    driver_alone = "stuck at the light, which is right but for asking"
    expected = "ask"
    suspends = frozenset({"blocked", "tick_runtime"})

    def happen(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario(stop_entries=False)
        self.hold_lights(green=[])
        yield
