"""HazardAtSideLaneTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.obstacle import SlowBicycles, TwoWays
from stucksolver_eval.scenarios.parameters import Number
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.setting import Setting


@scenario
class HazardAtSideLaneTwoWays(SlowBicycles):
    """Two slow bicycles at the edge of the only lane; the hero passes them in a gap of the oncoming traffic."""

    type = "HazardAtSideLaneTwoWays"
    starts = "the bicycles set off at the trigger"
    needs_map = TwoWays.needs_map
    # As in the public benchmark, which forgets to switch it on again.
    keeps_suspended = frozenset({"wrong_lane"})
    oncoming_gap_m = Number("frequency", 100.0, "m")

    def needs(self, setting: Setting) -> str | None:
        return TwoWays.needs(self, setting)  # type: ignore[arg-type]

    def begin_way_past(self) -> None:
        self.suspended.add("wrong_lane")
        self.traffic.change_opposite_behavior(spawn_m=self.oncoming_gap_m)

    def end_way_past(self) -> None:
        self.traffic.change_opposite_behavior()
