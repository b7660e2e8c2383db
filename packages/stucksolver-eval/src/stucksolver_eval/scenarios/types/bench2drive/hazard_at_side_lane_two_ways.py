"""HazardAtSideLaneTwoWays."""

from __future__ import annotations

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.obstacle import SlowBicycles, TwoWayObstacle
from stucksolver_eval.scenarios.parameters import NumberParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw, RideDistanceDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class HazardAtSideLaneTwoWays(SlowBicycles):
    """Two slow bicycles ride at the edge of the only lane; the hero passes them in a gap of the oncoming traffic."""

    type = "HazardAtSideLaneTwoWays"
    placed = SuitePlacement(
        "bench220",
        1110,
        LaneSites(two_ways, 180),
        {
            "distance": IntegerDraw(41, 45),
            "frequency": IntegerDraw(75, 100),
            "bicycle_drive_distance": RideDistanceDraw(80, 140),
            "bicycle_speed": IntegerDraw(7, 11),
        },
    )
    driver_alone = "stuck behind the bicycles when they stop"
    starts = "the bicycles start at the trigger"
    needs_map = TwoWayObstacle.needs_map
    # The public benchmark never switches it on again.
    keeps_suspended = frozenset({"wrong_lane"})
    oncoming_gap_m = NumberParameter("frequency", 100.0, "m")

    def needs(self, setting: ScenarioContext) -> str | None:
        return TwoWayObstacle.needs(self, setting)  # type: ignore[arg-type]

    def begin_way_past(self) -> None:
        """Leave gaps in the oncoming traffic, and suspend the criterion for wrong lanes."""
        self.suspended.add("wrong_lane")
        self.traffic.change_opposite_behavior(spawn_m=self.oncoming_gap_m)

    def end_way_past(self) -> None:
        """Restore the oncoming traffic."""
        self.traffic.change_opposite_behavior()
