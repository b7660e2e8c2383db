"""ParkingCrossingPedestrian."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.crossing_actors import ADULTS, WALKER_LIFT_M, walk_for
from stucksolver_eval.scenarios.families.lane_places import lane_of, offset_pose, side_driving_lane
from stucksolver_eval.scenarios.parameters import ChoiceParameter, NumberParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.lane_requirements import parking
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import ON_THE_RIGHT, IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

WALK_MPS = 2.0
"""Speed of the pedestrian (m/s)."""
WALK_M = 8.0
"""Length of the pedestrian's path (m)."""
SYNC_S = 2.15
"""Time of the hero to the crossing at which the pedestrian starts (s)."""
NEAR_M = 6.0
"""Distance of the hero at which the pedestrian starts in any case (m)."""
BEHIND_M = 0.8
"""Distance of the pedestrian behind the car (m)."""


@scenario
class ParkingCrossingPedestrian(Scenario):
    """A pedestrian steps out from behind a parked car and crosses in front of the hero."""

    type = "ParkingCrossingPedestrian"
    placed = SuitePlacement(
        "bench220",
        1260,
        LaneSites(parking, 125),
        {"distance": IntegerDraw(36, 45), "direction": ON_THE_RIGHT, "crossing_angle": IntegerDraw(0, 12)},
    )
    driver_alone = "completed: brakes"
    timeout_s = None
    starts = "the pedestrian starts when the hero is 2.15 s or 6 m away"
    needs_map = "a parking lane next to the hero's, or no driving lane there"
    blueprints = ADULTS
    distance_m = NumberParameter("distance", 12.0, "m")
    direction = ChoiceParameter("direction", "right", options=("left", "right"))
    angle_deg = NumberParameter("crossing_angle", 0.0, "°")

    def needs(self, setting: ScenarioContext) -> str | None:
        here = self.ahead(self.distance_m)
        if lane_of(here, carla.LaneType.Parking, self.direction) is None and side_driving_lane(here, self.direction):
            return (
                f"{self.distance_m:.0f} m beyond the trigger point the lane on the {self.direction} is a driving lane"
            )
        return None

    def stage(self) -> None:
        here = self.ahead(self.distance_m)
        found = lane_of(here, carla.LaneType.Parking, self.direction)
        # Without a parking lane the car is next to the driving lane, as on Bench2Drive's routes in Town02.
        parking, aside_m = (here, here.lane_width) if found is None else (found, 0.0)
        aside_m *= 1.0 if self.direction == "right" else -1.0
        # A parking lane on the other side has the opposite direction.
        against = parking.lane_id * here.lane_id < 0
        car = self.cast.must_spawn(self.cast.some_car(self.random), offset_pose(parking, aside_m))
        self.cast.hold(car)
        ahead_m = (car.half_length_m + BEHIND_M) * (-1.0 if against else 1.0)
        sign = 1.0 if self.direction == "right" or against else -1.0
        turn_deg = -sign * (90.0 + self.angle_deg)
        place = offset_pose(parking, aside_m, ahead_m, turn_deg=turn_deg)
        walker = self.cast.must_spawn(self.random.choice(ADULTS), place, lift_m=WALKER_LIFT_M)
        self._parts, self._yaw_deg = [car, walker], place.rotation.yaw
        self._place_s = self.s_at(self.distance_m) + abs(ahead_m)

    def script(self) -> Iterator[None]:
        place = self.ahead(self.distance_m).transform.location
        self.traffic.leave_crossing_space(place.x, place.y)
        yield from self.until(lambda: self.within(self._place_s, SYNC_S, NEAR_M))
        yield from walk_for(self, self._parts[1], self._yaw_deg, WALK_MPS, WALK_M)
        self.cast.remove(self._parts)
