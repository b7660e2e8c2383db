"""The others on ways that meet the route: who drives along a way, at what pace, and who will come by it.

CARLA's world frame, meters, radians, seconds.
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

LEAST_MPS = 0.5
"""Who is slower than this (m/s) stands."""
_ON_WAY_M = 1.5
_ALONG_COS = math.cos(math.radians(45.0))
STREAM = 3
"""So many vehicles on one way are a stream, which drives at one speed."""
NOISE_MPS = 1.5
"""By sensors each of their speeds is off by up to this (m/s): over a drive of four seconds, by a car's length."""
_STOPPING_MPS2 = 4.0
"""Someone who would have to brake harder than this does not stop."""
_SLOWING_MPS2 = 3.0
SHOWN_M = 15.0
_ENOUGH = 2
"""If `_ENOUGH` vehicles from a lane took other ways and none took this one, those farther away than `SHOWN_M` from the
junction are not expected to take it.
"""


class ConflictingVehicle(NamedTuple):
    """A vehicle on another way."""

    actor_id: int
    s: float
    speed: float
    half_length: float
    half_width: float


def vehicles_on_path(way: ConflictPath, others: NearbyObjects) -> list[ConflictingVehicle]:
    """Return those of the others that drive along a way."""
    if len(others) == 0:
        return []
    dx, dy = others.x[:, None] - way.x, others.y[:, None] - way.y
    nearest = np.argmin(dx * dx + dy * dy, axis=1)
    rows = np.arange(len(others))
    cos, sin = np.cos(way.yaw[nearest]), np.sin(way.yaw[nearest])
    along = dx[rows, nearest] * cos + dy[rows, nearest] * sin
    aside = dy[rows, nearest] * cos - dx[rows, nearest] * sin
    speed = others.vx * cos + others.vy * sin
    on_it = (np.abs(aside) < _ON_WAY_M) & (speed > _ALONG_COS * np.hypot(others.vx, others.vy))
    on_it &= np.abs(along) < others.half_length + 1.0
    return [
        ConflictingVehicle(
            others.actor_id[i],
            float(way.s[nearest[i]] + along[i]),
            float(speed[i]),
            float(others.half_length[i]),
            float(others.half_width[i]),
        )
        for i in np.flatnonzero(on_it).tolist()
    ]


def with_flow_speed(
    seen: Sequence[tuple[ConflictPath, ConflictingVehicle]],
) -> list[tuple[ConflictPath, ConflictingVehicle]]:
    """Return them with the median speed of their stream, where their own differs from it by no more than noise."""
    paces = {}
    for way in {id(way): way for way, _ in seen}.values():
        speeds = [item.speed for its, item in seen if its is way]
        paces[id(way)] = float(np.median(speeds)) if len(speeds) >= STREAM else math.nan
    usual = [abs(item.speed - paces[id(way)]) < NOISE_MPS for way, item in seen]
    return [
        (way, item._replace(speed=paces[id(way)]) if noise else item)
        for (way, item), noise in zip(seen, usual, strict=True)
    ]


def flow_speed_mps(coming: Sequence[tuple[ConflictPath, ConflictingVehicle]]) -> float:
    """Return the speed of priority traffic where the route joins it (m/s); unlimited without any."""
    return max((item.speed for way, item in coming if way.joins and way.goes_first), default=math.inf)


def comes(way: ConflictPath, other: ConflictingVehicle) -> bool:
    """True if it has the right of way, or will not stop without it."""
    front = other.s + other.half_length
    to_line = way.inside_s - front
    if other.speed**2 - way.bend_mps**2 > 2.0 * _SLOWING_MPS2 * max(to_line, 1.0) and to_line > 0.0:
        return False  # too fast to turn there: it goes another way
    stops = to_line > 0.0 and other.speed**2 < 2.0 * _STOPPING_MPS2 * to_line
    if way.goes_first and not (stops and any(is_red(light) for light in way.lights)):
        return True
    return not stops and (way.straight or to_line < -2.0)


def is_red(light: carla.TrafficLight) -> bool:
    """True if the light shows red."""
    return bool(light.state == carla.TrafficLightState.Red)


def moving(around: NearbyObjects) -> NearbyObjects:
    """Return those who drive or ride faster than `LEAST_MPS`."""
    return around.part((np.hypot(around.vx, around.vy) > LEAST_MPS) & ~around.is_walker)


class TurnStatistics:
    """The ways that traffic from each lane has been seen to take at one junction.

    A vehicle nearer than `shown_m` to the junction may still take any of them.
    """

    def __init__(self, shown_m: float = SHOWN_M) -> None:
        self._shown_m = shown_m
        self._took: dict[LaneKey, dict[int, ConflictPath]] = {}

    def see(self, seen: Sequence[tuple[ConflictPath, ConflictingVehicle]]) -> None:
        """Note who is where the ways meet."""
        for way, other in seen:
            if way.meets_s < other.s < way.parts_s:
                self._took.setdefault(way.approach, {})[other.actor_id] = way

    def expect(self, way: ConflictPath, other: ConflictingVehicle) -> bool:
        """True if the vehicle may take this way, as far as one can tell."""
        took = self._took.get(way.approach, {}).values()
        near = way.inside_s - other.s - other.half_length < self._shown_m
        return near or len(took) < _ENOUGH or any(item is way for item in took)
