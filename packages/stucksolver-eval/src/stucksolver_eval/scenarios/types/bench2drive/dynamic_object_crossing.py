"""DynamicObjectCrossing."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.crossing_actors import ADULTS, WALKER_LIFT_M, walk_for
from stucksolver_eval.scenarios.families.lane_places import edge_m, lane_of, offset_pose
from stucksolver_eval.scenarios.parameters import ChoiceParameter, NumberParameter, TextParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.lane_requirements import sidewalk
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import BLOCKERS, ON_THE_RIGHT, IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

WALK_MPS = 2.0
"""Speed of the pedestrian (m/s)."""
SYNC_S = 2.1
"""Time of the hero to the crossing at which the pedestrian starts (s)."""
SYNC_PER_DEG_S = 0.1 / 5.0
"""Addition to this time per degree of the crossing angle (s)."""
NEAR_M = 6.0
"""Distance of the hero at which the pedestrian starts in any case (m)."""
BEHIND_M = 0.8
"""Distance of the pedestrian behind the object (m)."""
CURB_M = 0.2
"""Distance of the object from the curb (m)."""


@scenario
class DynamicObjectCrossing(Scenario):
    """A pedestrian steps out from behind an object at the roadside and crosses in front of the hero."""

    type = "DynamicObjectCrossing"
    placed = SuitePlacement(
        "bench220",
        1070,
        LaneSites(sidewalk, 125),
        {
            "distance": IntegerDraw(33, 50),
            "direction": ON_THE_RIGHT,
            "blocker_model": BLOCKERS,
            "crossing_angle": IntegerDraw(0, 15),
        },
    )
    driver_alone = "completed: brakes"
    timeout_s = None
    starts = "the pedestrian starts when the hero is 2.1 s (0.1 s more for each 5° of angle) or 6 m away"
    needs_map = "a sidewalk or shoulder along the road"
    blueprints = ADULTS
    distance_m = NumberParameter("distance", 12.0, "m")
    direction = ChoiceParameter("direction", "right", options=("left", "right"))
    blocker = TextParameter("blocker_model", "static.prop.vendingmachine")
    angle_deg = NumberParameter("crossing_angle", 0.0, "°")

    def needs(self, setting: ScenarioContext) -> str | None:
        if not setting.cast.knows(self.blocker):
            return f"the blueprint library has no {self.blocker}"
        lane = self.ahead(self.distance_m)
        kinds = (carla.LaneType.Sidewalk, carla.LaneType.Shoulder)
        if all(lane_of(lane, kind, self.direction) is None for kind in kinds):
            return (
                f"{self.distance_m:.0f} m beyond the trigger there is no sidewalk or shoulder on the {self.direction}"
            )
        return None

    def stage(self) -> None:
        lane = self.ahead(self.distance_m)
        sign = 1.0 if self.direction == "right" else -1.0
        blocker = self.cast.keep_below(self.blocker)
        self._offset_m = edge_m(lane, self.direction) + blocker.half_width_m + CURB_M
        self.cast.bring(blocker, offset_pose(lane, sign * self._offset_m), lift_m=0.0)
        ahead_m = blocker.half_length_m + BEHIND_M
        # The walker faces the road, turned toward the hero by the angle.
        turn_deg = -sign * (90.0 + self.angle_deg)
        place = offset_pose(lane, sign * self._offset_m, ahead_m, turn_deg=turn_deg)
        walker = self.cast.must_spawn(self.random.choice(ADULTS), place, lift_m=WALKER_LIFT_M)
        self._parts = [blocker, walker]
        self._yaw_deg = place.rotation.yaw
        self._place_s = self.s_at(self.distance_m) + ahead_m

    def script(self) -> Iterator[None]:
        # Oncoming traffic must not hit the walker.
        place = self.ahead(self.distance_m).transform.location
        self.traffic.leave_crossing_space(place.x, place.y)
        sync_s = SYNC_S + SYNC_PER_DEG_S * self.angle_deg
        yield from self.until(lambda: self.within(self._place_s, sync_s, NEAR_M))
        yield from walk_for(self, self._parts[1], self._yaw_deg, WALK_MPS, 2.0 * self._offset_m)
        self.cast.remove(self._parts)
