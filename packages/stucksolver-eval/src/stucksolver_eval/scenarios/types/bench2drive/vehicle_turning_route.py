"""VehicleTurningRoute."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.scenarios.families.crossing_actors import BICYCLES
from stucksolver_eval.scenarios.families.junction import JunctionScenario
from stucksolver_eval.scenarios.families.lane_places import edge_m, offset_pose
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import TURNS, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement

BEYOND_M = 11.0
"""Distance of the crossing beyond the junction (m)."""
RIDE_MPS = 1.8
"""Speed of the bicycle (m/s)."""
SYNC_S = 1.8
"""Time of the hero to the crossing at which the bicycle starts (s)."""
NEAR_M = 6.0
"""Distance of the hero at which the bicycle starts in any case (m)."""


@scenario
class VehicleTurningRoute(JunctionScenario):
    """After the hero's turn, a bicycle crosses its road from the right."""

    type = "VehicleTurningRoute"
    placed = SuitePlacement("bench220", 1410, JunctionSites(TURNS))
    driver_alone = "completed: brakes"
    timeout_s = None
    starts = "the bicycle starts when the hero is 1.8 s or 6 m from the crossing"
    blueprints = BICYCLES

    def stage(self) -> None:
        self._place_s = min(self.exit_s + BEYOND_M, self.setting.route.length_m)
        lane = self.setting.route.waypoint_at(self._place_s)
        self._offset_m = edge_m(lane) + 1.0
        place = offset_pose(lane, self._offset_m, turn_deg=-90.0)
        self._bicycle = self.cast.must_spawn(self.random.choice(BICYCLES), place)

    def script(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario(remove_exits=[self.exit], stop_entries=False)
        yield from self.until(lambda: self.within(self._place_s, SYNC_S, NEAR_M))
        bicycle = self._bicycle
        bicycle.actor.enable_constant_velocity(carla.Vector3D(RIDE_MPS, 0.0, 0.0))
        start = self.cast.state(bicycle)
        end_s = self.cast.time_s + 4.0 * self._offset_m / RIDE_MPS
        while self.cast.time_s < end_s:
            now = self.cast.state(bicycle)
            if start.distance_m(now.x, now.y) > 2.0 * self._offset_m:
                break
            yield
        self.cast.remove([bicycle])
