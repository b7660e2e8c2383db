"""InvadingTurn."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.background_traffic.lanes import oncoming_lanes
from stucksolver_eval.scenarios.families.lane_places import offset_pose
from stucksolver_eval.scenarios.families.obstacle import TwoWayObstacle
from stucksolver_eval.scenarios.parameters import NumberParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import bend
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import HundredthsDraw, IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

SPACING_M = (40.0, 40.0)
"""Range of distances between oncoming cars (m)."""
HALF_CAR_M = 0.7
"""Part of a car's half width that stays on its own side (m)."""
BEYOND_M = 30.0
"""Distance beyond the bend at which the scenario ends (m)."""
CONE = "static.prop.constructioncone"
CONES_M = 6.0
"""Distance between cones (m)."""


@scenario
class InvadingTurn(TwoWayObstacle):
    """Oncoming cars cross the center line because of cones on their side; the hero must keep right."""

    type = "InvadingTurn"
    placed = SuitePlacement(
        "bench220",
        1160,
        LaneSites(bend, 125, direct=False),
        {"distance": IntegerDraw(50, 60), "offset": HundredthsDraw(0.18, 0.39)},
    )
    driver_alone = "completed, with near misses"
    starts = "the oncoming cars come from the trigger on"
    blueprints = (CONE,)
    simplified = "the oncoming cars hold their speed independently of the hero, until one has touched it"
    distance_m = NumberParameter("distance", 100.0, "m")
    offset_m = NumberParameter("offset", 0.25, "m")

    def place_obstacle(self) -> tuple[float, float]:
        self._cones = []
        count = int(self.distance_m // CONES_M)
        for k in range(count):
            for lane in oncoming_lanes(self.ahead(k * CONES_M))[:1]:
                place = offset_pose(lane, lane.lane_width / 2.0 - self.offset_m)
                self._cones.append((self.cast.keep_below(CONE), place))
        return 0.0, self.distance_m

    def script(self) -> Iterator[None]:
        self.traffic.remove_road_lane(self.ahead(0.0))
        self.traffic.change_opposite_behavior(active=False)
        self.traffic.clear_opposite()
        for cone, place in self._cones:
            self.cast.bring(cone, place, lift_m=0.0)
        lane = oncoming_lanes(self.ahead(self.distance_m))[0]
        shift_m = -(self.offset_m + lane.lane_width / 2.0 - HALF_CAR_M)
        flow = self.oncoming_flow(shift_m, SPACING_M, constant=True)
        yield from self.along(flow, self.trigger_s_m + self.distance_m + BEYOND_M)
        flow.clear()
        self.cast.remove([cone for cone, _ in self._cones])
        self.traffic.readd_road_lane(self.ahead(0.0))
        self.traffic.change_opposite_behavior(active=True)
