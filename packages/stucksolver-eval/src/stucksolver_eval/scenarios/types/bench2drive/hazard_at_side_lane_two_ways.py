"""HazardAtSideLaneTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenario_context import Setting
from stucksolver_eval.scenarios.families.obstacle import SlowBicycles, TwoWays
from stucksolver_eval.scenarios.parameters import Number
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import Along
from stucksolver_eval.sites.parameter_draws import Ride, Value
from stucksolver_eval.sites.suite_placement import Placed


@scenario
class HazardAtSideLaneTwoWays(SlowBicycles):
    """Two slow bicycles ride at the edge of the only lane; the hero passes them in a gap of the oncoming traffic."""

    type = "HazardAtSideLaneTwoWays"
    placed = Placed(
        "bench220",
        1110,
        Along(two_ways, 180),
        {
            "distance": Value(41, 45),
            "frequency": Value(75, 100),
            "bicycle_drive_distance": Ride(80, 140),
            "bicycle_speed": Value(7, 11),
        },
    )
    driver_alone = "stuck behind the bicycles once they stop"
    starts = "the bicycles start at the trigger"
    needs_map = TwoWays.needs_map
    # As in the public benchmark, which never switches it on again.
    keeps_suspended = frozenset({"wrong_lane"})
    oncoming_gap_m = Number("frequency", 100.0, "m")

    def needs(self, setting: Setting) -> str | None:
        return TwoWays.needs(self, setting)  # type: ignore[arg-type]

    def begin_way_past(self) -> None:
        """Leave gaps in the oncoming traffic, and suspend the criterion for wrong lanes."""
        self.suspended.add("wrong_lane")
        self.traffic.change_opposite_behavior(spawn_m=self.oncoming_gap_m)

    def end_way_past(self) -> None:
        """Restore the oncoming traffic."""
        self.traffic.change_opposite_behavior()
