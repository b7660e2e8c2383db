"""Computes the acceleration that each concern of the driver allows: cruise, end of the line, lights, hazards."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from stucksolver_carla.drivers.behavior.controllers import SteerController
from stucksolver_carla.drivers.behavior.local_planner import LocalPlanner
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.options import DriverOptions
from stucksolver_carla.drivers.behavior.path import Path, PlanarPose, flipped
from stucksolver_carla.drivers.behavior.profiles import (
    KMH,
    STOPPED_MPS,
    DriverProfile,
    cruise_speed,
    emergency,
    look_ahead,
    toward_gap,
    toward_speed,
    turn_speed,
    wanted_gap,
)
from stucksolver_carla.drivers.behavior.swept_path import WALKER_MARGIN_M, Hazard, nearest_hazards, sweep
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

DEFAULT_LIMIT_KMH = 30.0
"""Speed limit if the client reports none (km/h), as CARLA before the first sign."""
_SPEED_PREVIEW_S = 0.4
"""Preview time for the path's speed bound (s). Ours."""
_SPEED_GAIN = 1.2
"""Acceleration per speed error (1/s). Ours."""
HALT_MPS2 = 2.0
"""Deceleration of a halt with less room than wanted (m/s²). Ours."""
AT_REST_MPS = 0.05
"""Speed below which the ego is at rest and needs no halt (m/s). Ours."""
_TURN_COMMANDS = ("left", "right")


class EgoMotion(NamedTuple):
    """The ego at one tick, in the direction in which it should drive."""

    pose: PlanarPose
    z: float
    speed: float
    """Speed along the pose's heading (m/s); negative while the ego still rolls in the opposite direction."""
    yaw_rate: float

    def reversed_motion(self) -> EgoMotion:
        """Return the same motion for an ego that backs up."""
        return EgoMotion(flipped(self.pose), self.z, -self.speed, self.yaw_rate)


class PaceFactors(NamedTuple):
    """Additional acceleration (m/s²), and factor of the speed in bends, for a brisker drive."""

    more_mps2: float
    bends: float


USUAL = PaceFactors(0.0, 1.0)
"""The profile's own acceleration and speed."""


class AccelerationLimits:
    """The accelerations that the profile allows for the driven line and the objects around the ego."""

    def __init__(
        self, profile: DriverProfile, options: DriverOptions, model: VehicleModel, planner: LocalPlanner
    ) -> None:
        self._profile = profile
        self._options = options
        self._model = model
        self._planner = planner

    @property
    def deceleration(self) -> float:
        """Comfortable deceleration on the driven line (m/s²)."""
        following = self._planner.following
        return self._options.follow_deceleration if following else self._profile.deceleration

    def cruise(self, path: Path, speed: float, limit_kmh: float, command: str, pace: PaceFactors) -> float:
        """Return the acceleration for the path's speed bounds and, on the route, the speed limit and the turn speed.

        `pace` makes the drive brisker.
        """
        bound = pace.bends * path.speed_at(self._planner.where.s + speed * _SPEED_PREVIEW_S)
        if not self._planner.following:
            bound = min(bound, self.top_speed(limit_kmh))
            if command in _TURN_COMMANDS:
                bound = min(bound, turn_speed(limit_kmh or DEFAULT_LIMIT_KMH))
        profile = replace(self._profile, acceleration=self._profile.acceleration + pace.more_mps2)
        return toward_speed(speed, bound, profile)

    def top_speed(self, limit_kmh: float) -> float:
        """Return the profile's speed (m/s) at the speed limit `limit_kmh`, which is 0 if unknown."""
        return cruise_speed(self._profile, limit_kmh or DEFAULT_LIMIT_KMH)

    def end(self, path: Path, speed: float) -> float:
        """Return the acceleration for a stop at the end of the line."""
        return toward_gap(speed, path.length - self._planner.where.s, 0.0, self.deceleration)

    def stop_line(self, distance: float, speed: float, gap: float | None = None) -> float:
        """Return the acceleration for a stop before a line `distance` meters ahead of the front bumper.

        `gap` is the distance to the line at the stop (m); None takes that of the options.
        """
        room_m = distance - (self._options.stop_line_gap_m if gap is None else gap)
        return toward_gap(speed, room_m, 0.0, self._profile.deceleration)

    def wait(self, distance: float, speed: float) -> float:
        """Return the acceleration for a stop before a conflict path `distance` meters ahead, hard if necessary."""
        hard_mps2 = emergency(speed, distance, 0.0)
        return self.stop_line(distance, speed) if hard_mps2 is None else hard_mps2

    def behind(self, gap: float, lead_speed: float, speed: float) -> float:
        """Return the acceleration for following a lead vehicle that is still on another path, `gap` meters ahead.

        The gap is negative while the lead vehicle is alongside.
        """
        profile = self._profile
        room_m = gap - wanted_gap(profile, profile.braking_distance_m, lead_speed)
        return toward_gap(speed, room_m, lead_speed, profile.deceleration, profile.speed_decrease_kmh * KMH)

    def slow_to(self, target_mps: float, distance: float, speed: float) -> float:
        """Return the acceleration for `target_mps` at `distance` meters ahead of the front bumper."""
        deceleration = self._profile.deceleration
        target = math.sqrt(target_mps * target_mps + 2.0 * deceleration * max(distance, 0.0))
        return _SPEED_GAIN * (target - speed) - deceleration * speed / target

    def hazards(
        self,
        path: Path,
        motion: EgoMotion,
        around: NearbyObjects,
        side_margin_m: float | None = None,
        doubt_m: float = 0.0,
    ) -> list[Hazard]:
        """Return the objects in the swept path, nearest first.

        `side_margin_m` replaces the options' clearance at the ego's sides. `doubt_m`: see `nearest_hazards`.
        """
        following, speed = self._planner.following, max(motion.speed, 0.0)
        reach = max(SteerController.MIN_REACH_M, SteerController.REACH_S * speed)
        ahead = look_ahead(self._profile, speed)
        side = -1 if self._planner.reversing else 1
        swept = sweep(path, self._planner.where, motion.pose, self._model, reach, ahead, side)
        margin = self._options.follow_side_margin_m if following else self._options.side_margin_m
        margin = margin if side_margin_m is None else side_margin_m
        walker_margin = margin if following else WALKER_MARGIN_M
        return nearest_hazards(swept, around, self._model, margin, walker_margin, doubt_m)

    def hazard(self, hazard: Hazard, speed: float) -> float:
        """Return the acceleration for following or stopping behind a hazard, hard if necessary."""
        hard_mps2 = emergency(speed, hazard.gap, hazard.speed)
        if hard_mps2 is not None:
            return hard_mps2
        fall_back = self._profile.speed_decrease_kmh * KMH
        return toward_gap(speed, self._room_m(hazard), hazard.speed, self.deceleration, fall_back)

    def halt(self, hazard: Hazard, speed: float) -> float:
        """Return a firm deceleration for a stopped or crossing hazard closer than the wanted gap; otherwise infinity.

        `hazard` brakes less and less over the last meter. So after a late stop, or when a pedestrian steps out close
        ahead, the ego would creep up to the hazard.
        """
        is_close = self._room_m(hazard) < 0.0 and hazard.speed < STOPPED_MPS
        return -HALT_MPS2 if is_close and speed > AT_REST_MPS else math.inf

    def _room_m(self, hazard: Hazard) -> float:
        """Return the remaining distance to the wanted gap (m); negative if the ego is closer."""
        following, profile = self._planner.following, self._profile
        standing_gap_m = self._options.follow_gap_m if following else profile.braking_distance_m
        return hazard.gap - wanted_gap(profile, standing_gap_m, hazard.speed)
