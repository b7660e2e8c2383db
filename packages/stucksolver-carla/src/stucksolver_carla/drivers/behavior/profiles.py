"""The driver's behavior: the published profiles, and the acceleration that each object ahead allows.

Profiles and order of concerns (light, walker, vehicle, junction, cruise) are those of `BehaviorAgent` and
`behavior_types` (CARLA PythonAPI agents package, MIT). BehaviorAgent switches between full targets. Here each concern
allows an acceleration and the lowest one counts, so that stops are smooth. It never overtakes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

KMH = 1.0 / 3.6
STANDING_MPS = 0.5
EMERGENCY_FROM_MPS2 = 4.0
HARDEST_MPS2 = 9.5
_EMERGENCY_CLEARANCE_M = 1.0
_SPEED_GAIN = 1.2
_CLOSE_GAIN = 0.8
_ROOM_OF_A_STOP_M = 0.15
_LEADER_BRAKING_MPS2 = 20.0


@dataclass(frozen=True)
class DriverProfile:
    """One published behavior. The first six values are BehaviorAgent's; the others make them smooth."""

    max_speed_kmh: float
    speed_limit_margin_kmh: float
    """Kept below the speed limit."""
    speed_decrease_kmh: float
    """Largest speed below a leader's while falling back."""
    safety_time_s: float
    """Time to collision below which the driver reacts, and so how far it looks ahead."""
    min_proximity_m: float
    """Looks at least this far ahead."""
    braking_distance_m: float
    """Bumper gap kept to standing objects in the path."""
    headway_s: float
    """Added to the gap behind a moving leader, see `wanted_gap`."""
    deceleration: float
    """Comfortable braking (m/s²)."""
    lateral_accel: float
    """Largest sideways acceleration in bends (m/s²)."""
    acceleration: float = 2.0


PROFILES = {
    "cautious": DriverProfile(40.0, 6.0, 12.0, 3.0, 12.0, 6.0, 0.5, 2.0, 1.6, 1.5),
    "normal": DriverProfile(50.0, 3.0, 10.0, 3.0, 10.0, 5.0, 0.3, 2.5, 2.2),
    "aggressive": DriverProfile(70.0, 1.0, 8.0, 3.0, 8.0, 4.0, 0.2, 3.0, 3.0, 2.3),
}


def profile_named(name: str) -> DriverProfile:
    """Return the profile of that name.

    Raises:
        ValueError: There is none. The message lists the known ones.
    """
    if name not in PROFILES:
        raise ValueError(f"unknown behavior {name!r}; choose one of {', '.join(PROFILES)}")
    return PROFILES[name]


def cruise_speed(profile: DriverProfile, speed_limit_kmh: float) -> float:
    """Return the target speed (m/s): the profile's own, or a margin below the limit."""
    return max(min(profile.max_speed_kmh, speed_limit_kmh - profile.speed_limit_margin_kmh), 5.0) * KMH


def turn_speed(speed_limit_kmh: float) -> float:
    """Return the speed through a junction turn (m/s): 5 km/h below the limit, as BehaviorAgent; bends lower it."""
    return max(speed_limit_kmh - 5.0, 5.0) * KMH


def look_ahead(profile: DriverProfile, speed: float) -> float:
    """Return how far ahead of the bumper bodies are looked for (m) at `speed` (m/s)."""
    stopping = speed * speed / (2.0 * profile.deceleration)
    return profile.min_proximity_m + max(stopping + speed, profile.safety_time_s * speed)


def wanted_gap(profile: DriverProfile, standing_m: float, lead_speed: float) -> float:
    """Return the bumper gap behind a leader (m): `standing_m` at rest, more with headway and braking distance at
    speed.
    """
    return standing_m + profile.headway_s * lead_speed + lead_speed * lead_speed / (2.0 * _LEADER_BRAKING_MPS2)


def toward_speed(speed: float, target: float, profile: DriverProfile) -> float:
    """Return the acceleration (m/s²) that leads from `speed` to `target` (m/s)."""
    wanted = _SPEED_GAIN * (target - speed)
    return min(max(wanted, -profile.deceleration), profile.acceleration)


def toward_gap(speed: float, room: float, lead_speed: float, deceleration: float, fall_back: float = 2.8) -> float:
    """Return the acceleration (m/s²) that ends `room` meters ahead at `lead_speed`, braking with about `deceleration`.

    The target falls with the square root of the room and, near the end, in proportion to it, without a step in between.
    With negative room the target is below the leader's speed by at most `fall_back` (m/s).
    """
    linear = deceleration / _CLOSE_GAIN**2
    if room < linear:
        closing, slope = _CLOSE_GAIN * room, _CLOSE_GAIN
    else:
        closing = math.sqrt(2.0 * deceleration * (room - linear / 2.0))
        slope = deceleration / closing
    target = max(lead_speed + max(closing, -fall_back), 0.0)
    if target <= 0.0 or (lead_speed < STANDING_MPS and room < _ROOM_OF_A_STOP_M):
        target = slope = 0.0
    return _SPEED_GAIN * (target - speed) - slope * max(closing, 0.0)


def emergency(speed: float, gap: float, lead_speed: float) -> float | None:
    """Return hard braking (m/s², negative) if comfort no longer keeps a meter of distance; None if it does."""
    if speed <= lead_speed or speed < STANDING_MPS:
        return None
    needed = (speed * speed - lead_speed * lead_speed) / (2.0 * max(gap - _EMERGENCY_CLEARANCE_M, 0.1))
    return -min(1.2 * needed, HARDEST_MPS2) if needed > EMERGENCY_FROM_MPS2 else None
