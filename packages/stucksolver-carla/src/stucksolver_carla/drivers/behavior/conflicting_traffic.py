"""Finds the traffic on conflict paths: the vehicles on a path, their speeds, and the ones that the ego must yield to.

The frame is CARLA's world frame (m, rad, s).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import carla
import numpy as np

from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath
from stucksolver_carla.drivers.behavior.lane_graph import LaneKey
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects

MIN_MPS = 0.5
"""Speed below which a vehicle counts as stopped (m/s). Ours."""
_ON_PATH_M = 1.5
"""Maximum distance from a path to the center of a vehicle that drives along it (m). Ours."""
_SAME_DIRECTION_COS = math.cos(math.radians(45.0))
"""Cosine of the maximum angle between a path and the velocity of a vehicle that drives along it. Ours."""
MIN_FLOW_VEHICLES = 3
"""Minimum number of vehicles on one path that form a traffic flow with a common speed. Ours."""
NOISE_MPS = 1.5
"""Maximum error of a speed from sensors (m/s): a car's length over a drive of four seconds."""
_STOPPING_MPS2 = 4.0
"""Deceleration above which a vehicle is not expected to stop (m/s²). Ours."""
_SLOWING_MPS2 = 3.0
"""Deceleration above which a vehicle is not expected to slow down for a bend (m/s²). Ours."""
COMMITTED_M = 15.0
"""Distance to the junction below which a vehicle may take any path, whatever earlier vehicles did (m). Ours."""
_MIN_OBSERVATIONS = 2
"""Number of vehicles from one lane after which paths that none of them took are not expected. Ours."""


class ConflictingVehicle(NamedTuple):
    """A vehicle on a conflict path. `s` is the arc length of its center (m)."""

    actor_id: int
    s: float
    speed: float
    half_length: float
    half_width: float


def vehicles_on_path(path: ConflictPath, others: NearbyObjects) -> list[ConflictingVehicle]:
    """Return the vehicles that drive along a path."""
    if len(others) == 0:
        return []
    dx, dy = others.x[:, None] - path.x, others.y[:, None] - path.y
    nearest = np.argmin(dx * dx + dy * dy, axis=1)
    rows = np.arange(len(others))
    cos, sin = np.cos(path.yaw[nearest]), np.sin(path.yaw[nearest])
    along = dx[rows, nearest] * cos + dy[rows, nearest] * sin
    aside = dy[rows, nearest] * cos - dx[rows, nearest] * sin
    speed = others.vx * cos + others.vy * sin
    is_on_path = (np.abs(aside) < _ON_PATH_M) & (speed > _SAME_DIRECTION_COS * np.hypot(others.vx, others.vy))
    is_on_path &= np.abs(along) < others.half_length + 1.0
    return [
        ConflictingVehicle(
            others.actor_id[i],
            float(path.s[nearest[i]] + along[i]),
            float(speed[i]),
            float(others.half_length[i]),
            float(others.half_width[i]),
        )
        for i in np.flatnonzero(is_on_path).tolist()
    ]


def with_flow_speed(
    pairs: Sequence[tuple[ConflictPath, ConflictingVehicle]],
) -> list[tuple[ConflictPath, ConflictingVehicle]]:
    """Return the pairs with the median speed of the flow for vehicles that differ from it by no more than noise."""
    speeds_mps = {}
    for path in {id(path): path for path, _ in pairs}.values():
        speeds = [vehicle.speed for other_path, vehicle in pairs if other_path is path]
        speeds_mps[id(path)] = float(np.median(speeds)) if len(speeds) >= MIN_FLOW_VEHICLES else math.nan
    is_noise = [abs(item.speed - speeds_mps[id(path)]) < NOISE_MPS for path, item in pairs]
    return [
        (path, item._replace(speed=speeds_mps[id(path)]) if noise else item)
        for (path, item), noise in zip(pairs, is_noise, strict=True)
    ]


def flow_speed_mps(pairs: Sequence[tuple[ConflictPath, ConflictingVehicle]]) -> float:
    """Return the speed of the priority traffic that the route joins (m/s); infinity without any."""
    return max((item.speed for path, item in pairs if path.joins and path.goes_first), default=math.inf)


def will_conflict(path: ConflictPath, other: ConflictingVehicle) -> bool:
    """Return True if a vehicle has the right of way, or is not expected to stop without it."""
    front = other.s + other.half_length
    to_line = path.inside_s - front
    if other.speed**2 - path.bend_mps**2 > 2.0 * _SLOWING_MPS2 * max(to_line, 1.0) and to_line > 0.0:
        return False  # too fast for this bend, so it takes another path
    can_stop = to_line > 0.0 and other.speed**2 < 2.0 * _STOPPING_MPS2 * to_line
    if path.goes_first and not (can_stop and any(is_red(light) for light in path.lights)):
        return True
    return not can_stop and (path.straight or to_line < -2.0)


def is_red(light: carla.TrafficLight) -> bool:
    """Return True if the light is red."""
    return bool(light.state == carla.TrafficLightState.Red)


def moving_vehicles(around: NearbyObjects) -> NearbyObjects:
    """Return the objects faster than `MIN_MPS`, without pedestrians."""
    return around.part((np.hypot(around.vx, around.vy) > MIN_MPS) & ~around.is_walker)


class TurnStatistics:
    """The paths that traffic from each lane was observed to take at one junction.

    A vehicle nearer than `committed_m` to the junction may take any path.
    """

    def __init__(self, committed_m: float = COMMITTED_M) -> None:
        self._committed_m = committed_m
        self._observed_turns: dict[LaneKey, dict[int, ConflictPath]] = {}

    def observe(self, pairs: Sequence[tuple[ConflictPath, ConflictingVehicle]]) -> None:
        """Store which vehicles are in the conflict with the route now."""
        for path, other in pairs:
            if path.meets_s < other.s < path.parts_s:
                self._observed_turns.setdefault(path.approach, {})[other.actor_id] = path

    def may_take(self, path: ConflictPath, other: ConflictingVehicle) -> bool:
        """Return True if the vehicle may take this path according to the observations."""
        observed = self._observed_turns.get(path.approach, {}).values()
        is_near = path.inside_s - other.s - other.half_length < self._committed_m
        return is_near or len(observed) < _MIN_OBSERVATIONS or any(item is path for item in observed)
