"""The acceleration that each concern of the driver allows: cruise, end of the line, lights, bodies in the path."""

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
    STANDING_MPS,
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
_SPEED_PREVIEW_S = 0.4
_SPEED_GAIN = 1.2
HALTS_MPS2 = 2.0
"""How firmly it halts where there is less room than wanted (m/s²)."""
STANDS_MPS = 0.05
"""A slower vehicle stands, and need not halt (m/s)."""
_TURNS = ("left", "right")


class EgoMotion(NamedTuple):
    """The ego at one tick, seen in the direction in which it should drive."""

    pose: PlanarPose
    z: float
    speed: float
    """Speed along the pose's heading (m/s); negative while it still rolls the other way."""
    yaw_rate: float

    def backwards(self) -> EgoMotion:
        """The same motion for a vehicle that backs up."""
        return EgoMotion(flipped(self.pose), self.z, -self.speed, self.yaw_rate)


class PaceFactors(NamedTuple):
    """How brisk a drive is: acceleration above the usual one (m/s²), and a factor on the speed in bends."""

    more_mps2: float
    bends: float


USUAL = PaceFactors(0.0, 1.0)


class AccelerationLimits:
    """The accelerations that the profile allows for the line being driven and the bodies around."""

    def __init__(
        self, profile: DriverProfile, options: DriverOptions, model: VehicleModel, planner: LocalPlanner
    ) -> None:
        self._profile = profile
        self._options = options
        self._model = model
        self._planner = planner

    @property
    def deceleration(self) -> float:
        """Comfortable braking (m/s²) on the line being driven."""
        following = self._planner.following
        return self._options.follow_deceleration if following else self._profile.deceleration

    def cruise(self, path: Path, speed: float, limit_kmh: float, command: str, pace: PaceFactors) -> float:
        """Keep to the path's bounds and, on the route, to the speed limit and the speed of junction turns.

        `pace` says how much brisker than usual to drive.
        """
        bound = pace.bends * path.speed_at(self._planner.where.s + speed * _SPEED_PREVIEW_S)
        if not self._planner.following:
            bound = min(bound, self.top_speed(limit_kmh))
            if command in _TURNS:
                bound = min(bound, turn_speed(limit_kmh or DEFAULT_LIMIT_KMH))
        brisk = replace(self._profile, acceleration=self._profile.acceleration + pace.more_mps2)
        return toward_speed(speed, bound, brisk)

    def top_speed(self, limit_kmh: float) -> float:
        """Return the profile's speed (m/s) at the speed limit `limit_kmh`; 0 if that is not known."""
        return cruise_speed(self._profile, limit_kmh or DEFAULT_LIMIT_KMH)

    def end(self, path: Path, speed: float) -> float:
        """Stop where the line ends."""
        return toward_gap(speed, path.length - self._planner.where.s, 0.0, self.deceleration)

    def stop_line(self, distance: float, speed: float, gap: float | None = None) -> float:
        """Stop before a line `distance` meters ahead of the front bumper, by `gap` meters or as the options say."""
        room = distance - (self._options.stop_line_gap_m if gap is None else gap)
        return toward_gap(speed, room, 0.0, self._profile.deceleration)

    def wait(self, distance: float, speed: float) -> float:
        """Stop before the way of others `distance` meters ahead of the front bumper, hard if necessary."""
        hard = emergency(speed, distance, 0.0)
        return self.stop_line(distance, speed) if hard is None else hard

    def behind(self, gap: float, lead_speed: float, speed: float) -> float:
        """Fall in behind a leader that is still on another way, `gap` meters ahead; it may still be abreast."""
        profile = self._profile
        room = gap - wanted_gap(profile, profile.braking_distance_m, lead_speed)
        return toward_gap(speed, room, lead_speed, profile.deceleration, profile.speed_decrease_kmh * KMH)

    def slow_to(self, target_mps: float, distance: float, speed: float) -> float:
        """Slow down to that speed at `distance` meters ahead of the front bumper."""
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
        """Return the bodies in the way, nearest first, with another margin beside the ego than the options' if
        given. `doubt_m`: see `nearest_hazards`.
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
        """Follow or stop behind one of them, hard if necessary."""
        hard = emergency(speed, hazard.gap, hazard.speed)
        if hard is not None:
            return hard
        fall_back = self._profile.speed_decrease_kmh * KMH
        return toward_gap(speed, self._room_m(hazard), hazard.speed, self.deceleration, fall_back)

    def halt(self, hazard: Hazard, speed: float) -> float:
        """Halt before somebody or something that stands or crosses with less room than wanted; infinity otherwise.

        `hazard` brakes ever less as the speed falls, over the last meter: after a late stop, or when someone steps out
        close ahead, the ego would creep up to them.
        """
        close = self._room_m(hazard) < 0.0 and hazard.speed < STANDING_MPS
        return -HALTS_MPS2 if close and speed > STANDS_MPS else math.inf

    def _room_m(self, hazard: Hazard) -> float:
        """Return how far the ego may still go on (m); negative if it is nearer than wanted."""
        following, profile = self._planner.following, self._profile
        standing = self._options.follow_gap_m if following else profile.braking_distance_m
        return hazard.gap - wanted_gap(profile, standing, hazard.speed)
