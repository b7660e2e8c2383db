"""Defines the driver's published profiles, and the acceleration that each object ahead allows.

Profiles and order of concerns (light, walker, vehicle, junction, cruise) are those of `BehaviorAgent` and
`behavior_types` (CARLA PythonAPI agents package, MIT). BehaviorAgent switches between full targets. In this driver each
concern allows an acceleration and the lowest one counts, so that stops are smooth. The driver never overtakes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

KMH = 1.0 / 3.6
"""One km/h (m/s)."""
STOPPED_MPS = 0.5
"""Speed below which an object counts as stopped (m/s). Ours."""
EMERGENCY_FROM_MPS2 = 4.0
"""Required deceleration from which the driver brakes hard (m/s²). Ours."""
HARDEST_MPS2 = 9.5
"""Maximum deceleration (m/s²). Ours; about what dry tires hold."""
_EMERGENCY_CLEARANCE_M = 1.0
"""Gap that hard braking leaves (m). Ours."""
_SPEED_GAIN = 1.2
"""Acceleration per speed error (1/s). Ours."""
_CLOSE_GAIN = 0.8
"""Closing speed per remaining distance near the gap (1/s). Ours."""
_STOP_TOLERANCE_M = 0.15
"""Remaining distance to a stopped object at which the ego stops (m). Ours."""
_LEADER_BRAKING_MPS2 = 20.0
"""Deceleration in the speed-dependent part of the wanted gap (m/s²). Ours."""


@dataclass(frozen=True)
class DriverProfile:
    """One published behavior. The first six values are BehaviorAgent's. The others are ours, for a smooth drive."""

    max_speed_kmh: float
    """Maximum speed (km/h)."""
    speed_limit_margin_kmh: float
    """Margin to the speed limit (km/h)."""
    speed_decrease_kmh: float
    """Maximum speed below a lead vehicle's while the ego falls back (km/h)."""
    safety_time_s: float
    """Time to collision below which the driver reacts (s). It determines the look-ahead distance."""
    min_proximity_m: float
    """Minimum look-ahead distance (m)."""
    braking_distance_m: float
    """Bumper gap to stopped objects in the path (m)."""
    headway_s: float
    """Time gap added behind a moving lead vehicle (s); see `wanted_gap`."""
    deceleration: float
    """Comfortable deceleration (m/s²)."""
    lateral_accel: float
    """Maximum lateral acceleration in bends (m/s²)."""
    acceleration: float = 2.0
    """Comfortable acceleration (m/s²)."""


PROFILES = {
    "cautious": DriverProfile(40.0, 6.0, 12.0, 3.0, 12.0, 6.0, 0.5, 2.0, 1.6, 1.5),
    "normal": DriverProfile(50.0, 3.0, 10.0, 3.0, 10.0, 5.0, 0.3, 2.5, 2.2),
    "aggressive": DriverProfile(70.0, 1.0, 8.0, 3.0, 8.0, 4.0, 0.2, 3.0, 3.0, 2.3),
}


def profile_named(name: str) -> DriverProfile:
    """Return the profile with this name.

    Raises:
        ValueError: No profile has this name. The message lists all names.
    """
    if name not in PROFILES:
        raise ValueError(f"unknown behavior {name!r}; choose one of {', '.join(PROFILES)}")
    return PROFILES[name]


def cruise_speed(profile: DriverProfile, speed_limit_kmh: float) -> float:
    """Return the target speed (m/s): the profile's maximum, or a margin below the limit."""
    return max(min(profile.max_speed_kmh, speed_limit_kmh - profile.speed_limit_margin_kmh), 5.0) * KMH


def turn_speed(speed_limit_kmh: float) -> float:
    """Return the speed through a junction turn (m/s): 5 km/h below the limit, as BehaviorAgent; bends lower it."""
    return max(speed_limit_kmh - 5.0, 5.0) * KMH


def look_ahead(profile: DriverProfile, speed: float) -> float:
    """Return the look-ahead distance from the bumper (m) at `speed` (m/s)."""
    stopping = speed * speed / (2.0 * profile.deceleration)
    return profile.min_proximity_m + max(stopping + speed, profile.safety_time_s * speed)


def wanted_gap(profile: DriverProfile, stopped_gap_m: float, lead_speed: float) -> float:
    """Return the bumper gap behind a lead vehicle (m): `stopped_gap_m` plus headway and braking distance at speed."""
    return stopped_gap_m + profile.headway_s * lead_speed + lead_speed * lead_speed / (2.0 * _LEADER_BRAKING_MPS2)


def toward_speed(speed: float, target: float, profile: DriverProfile) -> float:
    """Return the acceleration (m/s²) that leads from `speed` to `target` (m/s)."""
    acceleration = _SPEED_GAIN * (target - speed)
    return min(max(acceleration, -profile.deceleration), profile.acceleration)


def toward_gap(speed: float, room: float, lead_speed: float, deceleration: float, fall_back: float = 2.8) -> float:
    """Return the acceleration (m/s²) that ends `room` meters ahead at `lead_speed`, braking with about `deceleration`.

    The target falls with the square root of the room and, near the end, in proportion to it, without a step in between.
    With negative room the target is below the leader's speed by at most `fall_back` (m/s).
    """
    linear_m = deceleration / _CLOSE_GAIN**2
    if room < linear_m:
        closing, slope = _CLOSE_GAIN * room, _CLOSE_GAIN
    else:
        closing = math.sqrt(2.0 * deceleration * (room - linear_m / 2.0))
        slope = deceleration / closing
    target = max(lead_speed + max(closing, -fall_back), 0.0)
    if target <= 0.0 or (lead_speed < STOPPED_MPS and room < _STOP_TOLERANCE_M):
        target = slope = 0.0
    return _SPEED_GAIN * (target - speed) - slope * max(closing, 0.0)


def emergency(speed: float, gap: float, lead_speed: float) -> float | None:
    """Return the acceleration of hard braking (m/s², negative) if comfortable braking leaves less than one meter.

    The result is None if comfortable braking suffices.
    """
    if speed <= lead_speed or speed < STOPPED_MPS:
        return None
    needed_mps2 = (speed * speed - lead_speed * lead_speed) / (2.0 * max(gap - _EMERGENCY_CLEARANCE_M, 0.1))
    return -min(1.2 * needed_mps2, HARDEST_MPS2) if needed_mps2 > EMERGENCY_FROM_MPS2 else None
