"""ControlLoss."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.scenarios.families.lane_places import offset_pose
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.scenario import Scenario
from stucksolver_eval.sites.lane_requirements import any_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.suite_placement import SuitePlacement

DEBRIS_M = (14.0, 48.0, 74.0)
"""Distances of the patches of debris beyond the trigger (m)."""
REACH_M = 2.0
"""Radius of a patch (m)."""
THROTTLE, THROTTLE_SIGMA = 0.03, 0.01
"""Mean and standard deviation of the disturbance of the throttle."""
STEER, STEER_SIGMA = 0.055, 0.015
"""Mean and standard deviation of the disturbance of the steering."""
ENDS_M = 110.0
"""Distance beyond the trigger at which the scenario ends (m)."""
DEBRIS = "static.prop.dirtdebris01"


@scenario
class ControlLoss(Scenario):
    """Debris on the road disturbs the hero's throttle and steering on contact."""

    type = "ControlLoss"
    placed = SuitePlacement("bench220", 1050, LaneSites(any_lane, 125, direct=False))
    driver_alone = "completed"
    timeout_s = None
    starts = "at each of three patches of debris, while the hero is within 2 m of it"
    blueprints = (DEBRIS,)

    def stage(self) -> None:
        self._patches = []
        for distance_m in DEBRIS_M:
            place = offset_pose(self.ahead(distance_m))
            self._patches.append(self.cast.must_spawn(DEBRIS, place, lift_m=0.0))
        self._signs = [(self.random.choice((-1, 1)), self.random.choice((-1, 1))) for _ in DEBRIS_M]

    def script(self) -> Iterator[None]:
        yield from self.until_passed(self.trigger_s_m + ENDS_M)

    def disturb(self, control: carla.VehicleControl) -> carla.VehicleControl:
        hero = self.hero
        for patch, (pedal, wheel) in zip(self._patches, self._signs, strict=True):
            here = self.cast.state(patch)
            if hero.distance_m(here.x, here.y) < REACH_M:
                return self._noisy(control, pedal, wheel)
        return control

    def _noisy(self, control: carla.VehicleControl, pedal: int, wheel: int) -> carla.VehicleControl:
        throttle = control.throttle + self.random.gauss(pedal * THROTTLE, THROTTLE_SIGMA)
        steer = control.steer + self.random.gauss(wheel * STEER, STEER_SIGMA)
        return carla.VehicleControl(
            throttle=min(max(throttle, 0.0), 1.0),
            steer=min(max(steer, -1.0), 1.0),
            brake=control.brake,
            hand_brake=control.hand_brake,
            reverse=control.reverse,
        )
