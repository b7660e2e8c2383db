"""ClosedRoad."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

import carla

from stucksolver_bridge.traffic_side import drives_on_left
from stucksolver_eval.scenarios.families.lane_places import offset_pose, way_turn_deg
from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.stuck_sites import closed_streets
from stucksolver_eval.sites.suite_placement import SuitePlacement

BARRIER, SIGN = "static.prop.streetbarrier", "static.prop.warningconstruction"
BARRIER_M = 1.2
"""Distance between two barriers (m)."""
MOST_EACH_SIDE = 20
"""Maximum number of barriers on each side."""
SIGN_BEFORE_M = 2.0
"""Distance of the sign before the barriers (m)."""
FOR_VEHICLES = carla.LaneType.Driving | carla.LaneType.Parking | carla.LaneType.Biking | carla.LaneType.Stop


@scenario
class ClosedRoad(StuckScenario):
    """The road is closed from curb to curb: leave the route and reach the destination another way."""

    type = "ClosedRoad"
    placed: ClassVar[SuitePlacement | None] = SuitePlacement("immobilized", 3140, closed_streets, only_in="grid_town")
    driver_alone = "stuck before the barrier"
    expected = "reroute"
    suspends = frozenset({"blocked", "route_deviation"})
    simplified = "no other vehicle drives into the closed road"
    needs_map = "another road from where the hero stops: in the suite the closed street starts at a junction"
    blueprints: ClassVar[tuple[str, ...]] = (BARRIER, SIGN)

    def script(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario()
        self.traffic.switch_route_sources(False)
        self.traffic.remove_behind()
        # The script runs until the end of the drive, because a hero that replans follows another route from here.
        yield from self.until(lambda: False)

    def stage(self) -> None:
        for place in row_across(self.setting.map, self.ahead(self.distance_m)):
            self.cast.must_spawn(BARRIER, place, lift_m=0.0)
        self.spawn_at(SIGN, -SIGN_BEFORE_M, 0.0, turn_deg=180.0)


def row_across(carla_map: carla.Map, here: carla.Waypoint) -> list[carla.Transform]:
    """Return the poses of a row of barriers across a road, over the width that vehicles can drive.

    If the waypoint `here` is in a junction, the row is perpendicular to the road that its lane leads into.
    """
    # Positions are mirrored in left-hand traffic (`lane_places`), so the turn is, too.
    turn = -way_turn_deg(here, here) if drives_on_left(here) else way_turn_deg(here, here)
    places = [_across(here, k * BARRIER_M, turn) for k in range(-MOST_EACH_SIDE, MOST_EACH_SIDE + 1)]
    on_road = [k for k, place in enumerate(places) if carla_map.get_waypoint(place.location, False, FOR_VEHICLES)]
    # Lanes that diverge in a junction leave gaps between them, which are paved too.
    return places[on_road[0] : on_road[-1] + 1]


def _across(waypoint: carla.Waypoint, aside_m: float, turn_deg: float) -> carla.Transform:
    """Return a barrier's pose `aside_m` to the right of a waypoint, on a road that turns right by `turn_deg`."""
    square = math.radians(turn_deg)
    along_m, right_m = -aside_m * math.sin(square), aside_m * math.cos(square)
    return offset_pose(waypoint, right_m, along_m, turn_deg=turn_deg + 90.0)
