"""LevelCrossing."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.families.lane_places import edge_m, offset_pose
from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.stuck_sites import level_crossings
from stucksolver_eval.sites.suite_placement import SuitePlacement

GATE, POST = "static.prop.crossinggate", "static.prop.crossinggatepost"
BEFORE_RAILS_M = 5.0
"""Distance of the gate before the rails (m)."""
LASTS_S = 35.0
"""Time until the gate rises (s)."""


@scenario
class LevelCrossing(StuckScenario):
    """A control: the gate of a level crossing is down for 35 s and then rises."""

    type = "LevelCrossing"
    placed = SuitePlacement("immobilized", 3230, level_crossings)
    driver_alone = "completed: waits 36 s"
    expected = "wait"
    simplified = "no train comes; the raised boom and the gate beyond the rails are not shown"
    starts = "the gate is down from the start, and rises 35 s after the hero came within 25 m"
    blueprints = (GATE, POST)

    def stage(self) -> None:
        lane = self.ahead(self.distance_m - BEFORE_RAILS_M)
        aside_m = edge_m(lane) + 0.3
        self.cast.must_spawn(POST, offset_pose(lane, aside_m), lift_m=0.0)
        # The boom extends to the right of its origin, so it is turned to reach over the hero's lane.
        self._gate = self.cast.must_spawn(GATE, offset_pose(lane, aside_m, -0.4, turn_deg=180.0), lift_m=0.0)

    def situation(self) -> Iterator[None]:
        # The boom reaches into the oncoming lane, which the gate on the other side closes.
        self.traffic.change_opposite_behavior(active=False)
        self.traffic.clear_opposite()
        yield from self.hero_near()
        yield from self.wait(LASTS_S)
        # A raised boom would still block the road for perception that ignores the roll of bounding boxes.
        self.cast.remove([self._gate])
        self.traffic.change_opposite_behavior(active=True)
