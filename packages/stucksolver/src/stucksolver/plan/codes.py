"""Closed lists of codes that a decision may use."""

from dataclasses import dataclass
from enum import Enum


class CauseCode(str, Enum):
    """Cause of an immobilization."""

    PARKED_VEHICLE = "parked_vehicle"
    DISABLED_VEHICLE = "disabled_vehicle"
    STATIC_OBSTACLE = "static_obstacle"
    BLOCKED_ROAD = "blocked_road"
    LOOP = "loop"
    UNKNOWN = "unknown"


class WaitReason(str, Enum):
    """Reason for a legitimate wait."""

    AT_DESTINATION = "at_destination"
    LIGHT = "light"
    STOP_SIGN = "stop_sign"
    QUEUE = "queue"
    PEOPLE = "people"
    YIELD = "yield"
    UNKNOWN_STOPPED = "unknown_stopped"
    NO_SAFE_WAY = "no_safe_way"


@dataclass(frozen=True)
class WaitLimits:
    """Durations for which each wait is legitimate (s). The defaults are the design's; a deployment may set its own."""

    light_s: float = 180.0
    queue_moved_within_s: float = 60.0
    unknown_vehicle_s: float = 10.0
    hazard_or_parked_s: float = 3.0
    yield_s: float = 120.0


QUESTIONS = {
    "S2.1": "Does the passenger ask for something that can be done?",
    "S2.2": "Is the vehicle at its destination?",
    "S2.3": "Is it moving along its route?",
    "S2.4": "Is it held by a light, a sign, a queue, people, or a duty to yield?",
    "S2.5": "Is it immobilized, and by what?",
}
"""The questions of the second step: S2.1 if there is guidance, otherwise the others."""


class Intent(str, Enum):
    """Intent of a road user: its present or next maneuver."""

    PARKED = "parked"
    STOPPED = "stopped"
    QUEUEING = "queueing"
    FOLLOWING = "following_lane"
    ONCOMING = "oncoming"
    CROSSING = "crossing"
    WAITING_TO_CROSS = "waiting_to_cross"
    OBSTRUCTING = "obstructing"
    UNKNOWN = "unknown"
