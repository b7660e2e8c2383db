"""VehicleTurningRoutePedestrian."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.families.crossing_actors import ADULTS, WALKER_LIFT_M, walk_for
from stucksolver_eval.scenarios.families.junction import JunctionScenario
from stucksolver_eval.scenarios.families.lane_places import edge_m, offset_pose
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import TURNS, JunctionSites
from stucksolver_eval.sites.suite_placement import SuitePlacement

BEYOND_M = 3.0
"""Distance of the crossing beyond the junction (m)."""
WALK_MPS = 1.8
"""Speed of the pedestrian (m/s)."""
SYNC_S = 2.2
"""Time of the hero to the crossing at which the pedestrian starts (s)."""
NEAR_M = 6.0
"""Distance of the hero at which the pedestrian starts in any case (m)."""


@scenario
class VehicleTurningRoutePedestrian(JunctionScenario):
    """Just after the hero's turn, a pedestrian crosses its road from the right."""

    type = "VehicleTurningRoutePedestrian"
    placed = SuitePlacement("bench220", 1420, JunctionSites(TURNS, rightmost=True))
    driver_alone = "completed: stops for the pedestrian"
    timeout_s = None
    starts = "the pedestrian starts when the hero is 2.2 s or 6 m from the crossing"
    blueprints = ADULTS
    # The public type adds a second collision test, so one collision counts twice.
    extra_criteria = frozenset({"collision"})

    def stage(self) -> None:
        self._place_s = min(self.exit_s + BEYOND_M, self.setting.route.length_m)
        lane = self.setting.route.waypoint_at(self._place_s)
        self._offset_m = edge_m(lane) + 1.0
        place = offset_pose(lane, self._offset_m, turn_deg=-90.0)
        self._yaw_deg = place.rotation.yaw
        self._walker = self.cast.must_spawn(self.random.choice(ADULTS), place, lift_m=WALKER_LIFT_M)

    def script(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario(remove_exits=[self.exit], stop_entries=False)
        yield from self.until(lambda: self.within(self._place_s, SYNC_S, NEAR_M))
        yield from walk_for(self, self._walker, self._yaw_deg, WALK_MPS, self._road_m())
        self.cast.remove([self._walker])

    def _road_m(self) -> float:
        """Return the distance to the other side of the road (m)."""
        lane = self.setting.route.waypoint_at(self._place_s)
        return self._offset_m + edge_m(lane, "left") + float(lane.lane_width) + 1.0
