"""PedestrianCrossing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import carla

from stucksolver_eval.actors import ScenarioActor
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.crossing_actors import ADULTS, WALKER_LIFT_M, together, walk_for
from stucksolver_eval.scenarios.families.junction import JunctionScenario
from stucksolver_eval.scenarios.families.lane_places import edge_m, lane_of, offset_pose
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import ALL_WAYS, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement

SYNC_S = 3.5
"""Time of the hero to the crossing at which the pedestrians start (s)."""
NEAR_M = 12.0
"""Distance of the hero at which they start in any case (m)."""
DELAY_S = (0.0, 1.5)
"""Range of the pedestrians' delays (s)."""
WALK_MPS = (1.3, 2.0)
"""Range of the pedestrians' speeds (m/s)."""
BEFORE_JUNCTION_M = 1.5
"""Distance of the crossing before the junction (m)."""
SPREAD_M = (0.0, -1.2, 1.2)
"""Positions of the pedestrians along the road, relative to the crossing (m)."""
ACROSS = 2.3
"""Length of the pedestrians' path, in multiples of their distance to the lane's center."""


@scenario
class PedestrianCrossing(JunctionScenario):
    """Three pedestrians cross the hero's road just before a junction."""

    type = "PedestrianCrossing"
    placed = SuitePlacement("bench220", 1290, JunctionSites(ALL_WAYS, rightmost=True))
    driver_alone = "completed: brakes"
    timeout_s = None
    starts = "the pedestrians start when the hero is 3.5 s or 12 m away, each with a delay of up to 1.5 s"
    needs_map = "a junction on the route with a sidewalk at its entry"
    blueprints = ADULTS

    def needs(self, setting: ScenarioContext) -> str | None:
        missing = super().needs(setting)
        if missing is None and lane_of(self._crossing, carla.LaneType.Sidewalk) is None:
            missing = "there is no sidewalk where the route enters its next junction"
        return missing

    @property
    def _crossing(self) -> Any:
        return self.setting.route.waypoint_at(self.entry_s - BEFORE_JUNCTION_M)

    def stage(self) -> None:
        lane = self._crossing
        self._offset_m = edge_m(lane) + 1.2
        self._walkers: list[ScenarioActor] = []
        for along_m in SPREAD_M:
            place = offset_pose(lane, self._offset_m, along_m, turn_deg=-90.0)
            self._yaw_deg = place.rotation.yaw
            self._walkers.append(self.cast.must_spawn(self.random.choice(ADULTS), place, lift_m=WALKER_LIFT_M))

    def script(self) -> Iterator[None]:
        place_s = self.entry_s - BEFORE_JUNCTION_M
        yield from self.until(lambda: self.within(place_s, SYNC_S, NEAR_M))
        yield from together(*(self._cross(walker) for walker in self._walkers))
        self.cast.remove(self._walkers)

    def _cross(self, walker: ScenarioActor) -> Iterator[None]:
        yield from self.wait(self.random.uniform(*DELAY_S))
        speed = self.random.uniform(*WALK_MPS)
        yield from walk_for(self, walker, self._yaw_deg, speed, ACROSS * self._offset_m)
