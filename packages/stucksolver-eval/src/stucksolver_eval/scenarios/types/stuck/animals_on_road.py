"""AnimalsOnRoad."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.scenarios.families.lane_places import offset_pose
from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import one_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

COW, DOG = "animal.cow", "animal.dog"
PLACES = ((COW, 0.0, -0.6), (COW, 2.6, 1.0), (DOG, -1.6, 1.2))
"""Blueprints of the animals, with their positions ahead and to the right (m)."""
LASTS_S = 25.0
"""Time until the animals leave (s)."""
WALK_MPS = 1.0
"""Speed of the animals (m/s)."""
AWAY_S = 9.0
"""Time that they walk (s)."""
BACK_M = 1.0
"""Distance that the hero may back up (m)."""


@scenario
class AnimalsOnRoad(StuckScenario):
    """Animals are on the road and walk away after a while: wait."""

    type = "AnimalsOnRoad"
    placed = SuitePlacement("immobilized", 3160, LaneSites(one_lane), {"distance": IntegerDraw(40, 48)})
    driver_alone = "completed: waits 28 s"
    expected = "wait"
    suspends = frozenset({"blocked"})
    starts = "the animals are present from the start, and leave 25 s after the hero came within 25 m"
    blueprints = (COW, DOG)

    def stage(self) -> None:
        self._animals = [
            self.cast.must_spawn(
                kind, offset_pose(self.ahead(self.distance_m + ahead_m), right_m, turn_deg=90.0), lift_m=BACK_M
            )
            for kind, ahead_m, right_m in PLACES
        ]

    def situation(self) -> Iterator[None]:
        yield from self.hero_near()
        yield from self.wait(LASTS_S)
        aside = offset_pose(self.ahead(self.distance_m), turn_deg=90.0).get_forward_vector()
        for animal in self._animals:
            control = carla.WalkerControl(aside, WALK_MPS, False)
            self.cast.send(carla.command.ApplyWalkerControl(animal.id, control))
        yield from self.wait(AWAY_S)
        self.cast.remove(self._animals)
