"""Driving outside the lanes, or in a wrong one (OutsideRouteLanesTest)."""

from __future__ import annotations

from typing import Any

import carla

from stucksolver_eval.criteria.criterion import Criterion, EgoTick, Infraction
from stucksolver_eval.criteria.route_position import RouteWalk

ALLOWED_OUT_M = 0.5
"""Distance beyond a lane's edge that is still allowed (m). As in OutsideRouteLanesTest."""
LEAVING_DEG = 120.0
"""Angle to the lane's direction above which the ego is in a wrong lane after a junction (degrees).

As in OutsideRouteLanesTest.
"""
JUMP_DEG = 150.0
"""Change of the lane's direction above which the ego has changed sides (degrees). As in OutsideRouteLanesTest."""
WINDOW = 3
"""Number of route points ahead that are searched. As in OutsideRouteLanesTest."""
WELL_INSIDE_M = 1.0
"""Distance from a lane's center that is inside any lane (m). It saves a second query of the map in the usual case."""


class OutsideLanes(Criterion):
    """The share of the driven route on which the ego was outside every lane or in the wrong direction; one entry."""

    kind = "outside_route_lanes"

    def __init__(self, carla_map: carla.Map, walk: RouteWalk, start: Any) -> None:
        super().__init__()
        self._map = carla_map
        self._walk = walk
        self._index = 0
        self._total_m = self._wrong_m = 0.0
        self._wrong_lane = False
        self._last = carla_map.get_waypoint(start)

    def update(self, moment: EgoTick) -> None:
        place = moment.location
        driving = self._map.get_waypoint(place)
        self._follow_lane(driving, float(moment.transform.rotation.yaw))
        wrong_lane = self._wrong_lane and "wrong_lane" not in moment.suspended
        wrong = wrong_lane or self._is_outside(place, driving)
        for index in range(self._index + 1, min(self._index + WINDOW + 1, len(self._walk))):
            if self._walk.passed(index, place):
                self._advance(index, wrong, moment.time_s)

    def _advance(self, index: int, wrong: bool, time_s: float) -> None:
        step_m = self._walk.s_m[index] - self._walk.s_m[self._index]
        self._index = index
        self._total_m += step_m
        self._wrong_m += step_m if wrong else 0.0
        if self._wrong_m > 0.0:
            percentage = 100.0 * self._wrong_m / self._total_m
            text = f"{self._wrong_m:.3f} m outside the route's lanes ({percentage:.2f}% of the completed route)"
            self.infractions = [Infraction(self.kind, time_s, text, percentage)]

    def _is_outside(self, place: Any, driving: Any) -> bool:
        """True if the distance to the nearest driving or parking lane's center exceeds half its width plus 0.5 m."""
        distance, width = place.distance(driving.transform.location), float(driving.lane_width)
        if distance < WELL_INSIDE_M:
            return False
        parking = self._map.get_waypoint(place, lane_type=carla.LaneType.Parking)
        if parking is not None:
            parking_distance = place.distance(parking.transform.location)
            if distance >= parking_distance:
                distance, width = parking_distance, float(parking.lane_width)
        return bool(distance > width / 2.0 + ALLOWED_OUT_M)

    def _follow_lane(self, here: Any, ego_yaw_deg: float) -> None:
        """Track whether the ego drives against its lane."""
        if here.is_junction:
            # Lanes cross each other in junctions.
            self._wrong_lane = False
        elif (here.road_id, here.lane_id) != (self._last.road_id, self._last.lane_id):
            lane_yaw = float(here.transform.rotation.yaw)
            if self._last.is_junction:
                self._wrong_lane = not between(lane_yaw - ego_yaw_deg, LEAVING_DEG)
            elif not between(float(self._last.transform.rotation.yaw) - lane_yaw, JUMP_DEG):
                # The ego has changed to the oncoming side, or back.
                self._wrong_lane = not self._wrong_lane
        self._last = here


def between(angle_deg: float, limit_deg: float) -> bool:
    """True if an angle is smaller than a limit on either side."""
    wrapped = angle_deg % 360.0
    return wrapped < limit_deg or wrapped > 360.0 - limit_deg
