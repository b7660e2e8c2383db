"""PeopleAtRedLight."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.families.crossing_actors import WALKER_LIFT_M, together, walk_for
from stucksolver_eval.scenarios.families.lane_places import offset_pose
from stucksolver_eval.scenarios.families.street import into_gear
from stucksolver_eval.scenarios.families.stuck import StuckAtLight
from stucksolver_eval.scenarios.registry import scenario

WALKERS = ("walker.pedestrian.0001", "walker.pedestrian.0017", "walker.pedestrian.0022")
"""Three adults of the same size with different looks. Each blueprint of CARLA has one look."""
PLACES_M = ((2.5, 5.5), (4.0, -6.5), (3.2, 8.0))
"""Positions of the pedestrians: distance beyond the stop line, and to the right of the lane's center (m).

They cross to the other side.
"""
WALK_MPS = 0.9
"""Speed of the pedestrians (m/s)."""
PAST_M = 4.0
"""Distance of their path beyond the lane (m)."""
SET_OFF_S = 6.0
"""Time after the trigger at which they start (s)."""
GREEN_S = 30.0
"""Time after the trigger at which the light turns green (s)."""


@scenario
class PeopleAtRedLight(StuckAtLight):
    """The hero's light is red, and pedestrians cross beyond its stop line; after 30 s it turns green."""

    type = "PeopleAtRedLight"
    starts = "the light is red from the trigger on; the pedestrians start 6 s later"
    blueprints = WALKERS

    def stage(self) -> None:
        into_gear(self.setting.hero)
        self._walkers = []
        for blueprint, (beyond_m, right_m) in zip(WALKERS, PLACES_M, strict=True):
            lane = self.setting.route.waypoint_at(self.entry_s + beyond_m)
            place = offset_pose(lane, right_m, turn_deg=-90.0 if right_m > 0 else 90.0)
            walker = self.cast.must_spawn(blueprint, place, lift_m=WALKER_LIFT_M)
            self._walkers.append((walker, place.rotation.yaw, 2.0 * abs(right_m) + PAST_M))

    def situation(self) -> Iterator[None]:
        self.hold_lights(green=[])
        end_s = self.cast.time_s + GREEN_S
        yield from self.wait(SET_OFF_S)
        yield from together(*(walk_for(self, walker, yaw, WALK_MPS, way_m) for walker, yaw, way_m in self._walkers))
        yield from self.wait(max(end_s - self.cast.time_s, 0.0))
        self.hold_lights(green=self.own_lights)
