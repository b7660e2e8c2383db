"""SchoolBus."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.actors.actor_pool import lamps
from stucksolver_eval.scenarios.families.crossing_actors import walk_for
from stucksolver_eval.scenarios.families.lane_places import edge_m, offset_pose
from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

BUS, CHILDREN = "vehicle.carlette.schoolbus", ("walker.pedestrian.0009", "walker.pedestrian.0010")
BOARDS_S = 10.0
"""Time until the children cross (s)."""
CROSS_MPS = 1.1
"""Speed of the children (m/s)."""
DRIVES_MPS = 7.0
"""Speed of the bus (m/s)."""


@scenario
class SchoolBus(StuckScenario):
    """A control: a school bus is stopped with its stop arm out while children cross; then it drives on."""

    type = "SchoolBus"
    placed = SuitePlacement("immobilized", 3220, LaneSites(two_ways), {"distance": IntegerDraw(40, 48)})
    driver_alone = "completed: waits 30 s"
    expected = "wait"
    starts = "children cross 10 s after the hero came within 25 m; then the bus drives on"
    blueprints = (BUS, *CHILDREN)

    def stage(self) -> None:
        self._bus = self.spawn_at(BUS)
        self.cast.lights(self._bus, lamps("Special1"))
        lane = self.ahead(self.distance_m)
        self._aside_m = edge_m(lane) + 1.0
        front_m = self._bus.half_length_m + 1.5
        self._children = [self.spawn_at(kind, front_m + k, self._aside_m) for k, kind in enumerate(CHILDREN)]

    def situation(self) -> Iterator[None]:
        yield from self.hero_near()
        yield from self.wait(BOARDS_S)
        lane = self.ahead(self.distance_m)
        way_m = self._aside_m + edge_m(lane, "left") + lane.lane_width + 1.0
        for child in self._children:
            yield from walk_for(self, child, offset_pose(lane, turn_deg=-90.0).rotation.yaw, CROSS_MPS, way_m)
        self.cast.lights(self._bus, lamps("NONE"))
        yield from self.wait(2.0)
        self.cars.drive(self._bus, lane, DRIVES_MPS, begin=False)
