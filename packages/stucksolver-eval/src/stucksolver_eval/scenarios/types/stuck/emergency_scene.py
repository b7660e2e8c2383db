"""EmergencyScene."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.actors.actor_pool import lamps
from stucksolver_eval.background_traffic.lanes import oncoming_lanes
from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import one_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

ENGINE, POLICE = "vehicle.carlamotors.firetruck", "vehicle.dodge.charger_police_2020"
OFFICER = "walker.pedestrian.0030"
LASTS_S = 45.0
"""Time until the scene disappears (s)."""


@scenario
class EmergencyScene(StuckScenario):
    """A control: a fire engine, a police car and people block the road; after a while they leave."""

    type = "EmergencyScene"
    placed = SuitePlacement("immobilized", 3240, LaneSites(one_lane), {"distance": IntegerDraw(40, 48)})
    driver_alone = "completed: waits 45 s"
    expected = "wait"
    starts = "the scene is present from the start, and is gone 45 s after the hero came within 25 m"
    simplified = "the scene disappears instead of driving off"
    blueprints = (ENGINE, POLICE, OFFICER)

    def stage(self) -> None:
        self._scene = [self.spawn_at(ENGINE, 8.0)]
        for lane in oncoming_lanes(self.ahead(self.distance_m)):
            self._scene.append(self.cast.must_spawn(POLICE, lane.transform))
            self.cast.hold(self._scene[-1])
        for member in self._scene:
            self.cast.lights(member, lamps("Special1", "Special2"))
        self._scene += [self.spawn_at(OFFICER, ahead_m, right_m) for ahead_m, right_m in ((0.0, 0.5), (1.5, -1.0))]

    def situation(self) -> Iterator[None]:
        self.traffic.change_opposite_behavior(active=False)
        self.traffic.clear_opposite()
        yield from self.hero_near()
        yield from self.wait(LASTS_S)
        self.cast.remove(self._scene)
        self.traffic.change_opposite_behavior(active=True)
