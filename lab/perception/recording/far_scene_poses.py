"""Poses of ego, vehicles and pedestrians for far scenes: positions on a map with a long view along a road.

The numbers are ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import carla
import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Floats

GRID_M = 5.0
"""Distance between the waypoints from which positions are drawn (m)."""
NEAREST_M, FARTHEST_M = 22.0, 230.0
"""Range of the vehicles' distances from the ego (m)."""
CONE_RAD = math.radians(33.0)
"""Half the angle of the cone in which vehicles are placed (rad), slightly less than half the camera's field of view."""
AXIS_RAD = math.radians(6.0)
"""Angle ahead within which a road must stay to be visible over a long distance (rad)."""
LONG_VIEW_SHARE = 0.85
"""Share of egos at positions with a long view along a road; the others are anywhere."""
AXIS_SHARE = 0.75
"""Share of vehicles near the axis of view, where houses hide few of them."""
PITCH_SIGMA_DEG = 0.1
"""Standard deviation of the body's pitch relative to the road, as from braking (degrees)."""
APART_M = 7.5
"""Least distance between two vehicles (m)."""
SPEEDS_MPS = (0.0, 4.0, 9.0, 14.0, 20.0)
"""Speeds of vehicles (m/s)."""
AWAY_M = 8000.0
"""Distance of unused actors from the map's origin (m), out of sight of the camera."""


@dataclass(frozen=True)
class ActorPose:
    """A pose in CARLA's world frame (left-handed, meters, degrees), and a speed along the heading."""

    x: float
    y: float
    z: float
    pitch_deg: float
    yaw_deg: float
    roll_deg: float
    speed_mps: float = 0.0
    """Speed along the heading (m/s)."""

    def transform(self) -> carla.Transform:
        """Return the pose as a `carla.Transform`."""
        rotation = carla.Rotation(pitch=self.pitch_deg, yaw=self.yaw_deg, roll=self.roll_deg)
        return carla.Transform(carla.Location(self.x, self.y, self.z), rotation)

    def moved(self, seconds: float) -> ActorPose:
        """Return the pose after driving straight ahead for this time (s)."""
        return self.moved_by(self.speed_mps * seconds)

    def moved_by(self, way: float) -> ActorPose:
        """Return the pose `way` meters straight ahead."""
        yaw, pitch = math.radians(self.yaw_deg), math.radians(self.pitch_deg)
        return replace(
            self,
            x=self.x + way * math.cos(yaw) * math.cos(pitch),
            y=self.y + way * math.sin(yaw) * math.cos(pitch),
            z=self.z + way * math.sin(pitch),
        )


def lane_places(carla_map: carla.Map) -> Floats:
    """Return positions in lanes, shape (n, 6): x, y, z (m), pitch, yaw, roll (degrees) in CARLA's world frame."""
    rows = []
    for waypoint in carla_map.generate_waypoints(GRID_M):
        at, turn = waypoint.transform.location, waypoint.transform.rotation
        rows.append((at.x, at.y, at.z, math.remainder(turn.pitch, 360.0), turn.yaw, turn.roll))
    return np.array(rows, np.float64)


class Places:
    """Draws random poses on one map."""

    def __init__(self, carla_map: carla.Map, random: np.random.Generator) -> None:
        self._random = random
        self._rows = lane_places(carla_map)
        self._chances = self._long_views()

    def ego(self) -> ActorPose:
        """Draw the ego's pose: on a lane, mostly with a long view, with a small lateral offset and heading error."""
        random = self._random
        long = random.random() < LONG_VIEW_SHARE
        place = int(random.choice(len(self._rows), p=self._chances if long else None))
        shifted = self._shifted(place, random.normal(0.0, 0.6), random.normal(0.0, 1.5))
        return replace(shifted, pitch_deg=shifted.pitch_deg + random.normal(0.0, PITCH_SIGMA_DEG))

    def ahead_of(self, ego: ActorPose, ahead_m: float) -> ActorPose:
        """Draw the pose of a stopped car in the ego's lane, its center `ahead_m` ahead, with a small offset."""
        side_m, yaw = self._random.normal(0.0, 0.3), math.radians(ego.yaw_deg)
        turned_deg = ego.yaw_deg + self._random.normal(0.0, 1.5)
        there = ego.moved_by(ahead_m)
        x, y = there.x - side_m * math.sin(yaw), there.y + side_m * math.cos(yaw)
        return replace(there, x=x, y=y, yaw_deg=turned_deg)

    def vehicles(self, ego: ActorPose, total: int, most: int) -> list[ActorPose]:
        """Draw poses for `total` vehicles, of which at most `most` are in view; the others are far away."""
        visible, bearing, distance = self._seen(ego)
        random = self._random
        taken: list[int] = []
        for _ in range(min(most, total)):
            narrow = np.abs(bearing[visible]) < AXIS_RAD
            among = visible[narrow] if random.random() < AXIS_SHARE and narrow.any() else visible
            wanted_m = random.uniform(NEAREST_M, FARTHEST_M)
            near = among[np.abs(distance[among] - wanted_m) < 12.0]
            if not len(near):
                continue
            place = int(random.choice(near))
            gaps = np.hypot(*(self._rows[taken][:, :2] - self._rows[place, :2]).T) if taken else np.array([np.inf])
            if gaps.min() >= APART_M:
                taken.append(place)
        return self._filled([self._vehicle(number) for number in taken], total)

    def walkers(self, ego: ActorPose, total: int, most: int) -> list[ActorPose]:
        """Draw poses for `total` pedestrians, of which at most `most` are within 120 m, on lanes or beside them."""
        visible, _, distance = self._seen(ego)
        near = visible[distance[visible] < 120.0]
        if not len(near):
            return self._filled([], total)
        places = [int(item) for item in self._random.choice(near, min(most, total))]
        posed = [
            self._shifted(place, self._random.normal(0.0, 4.0), self._random.uniform(0.0, 360.0)) for place in places
        ]
        return self._filled([replace(pose, z=pose.z + 1.0, speed_mps=1.2, pitch_deg=0.0) for pose in posed], total)

    def _vehicle(self, place: int) -> ActorPose:
        random = self._random
        turned = random.normal(0.0, 2.0)
        if random.random() < 0.10:
            turned = random.uniform(0.0, 360.0)
        sideways = random.normal(0.0, 0.35) + (2.0 if random.random() < 0.10 else 0.0)
        return replace(self._shifted(place, sideways, turned), speed_mps=float(random.choice(SPEEDS_MPS)))

    def _shifted(self, place: int, right_m: float, turned_deg: float) -> ActorPose:
        x, y, z, pitch, yaw, roll = (float(row) for row in self._rows[place])
        side = math.radians(yaw + 90.0)
        return ActorPose(x + right_m * math.cos(side), y + right_m * math.sin(side), z, pitch, yaw + turned_deg, roll)

    def _seen(self, ego: ActorPose) -> tuple[NDArray[np.int64], Floats, Floats]:
        """Return the indices of positions in the camera's cone, and bearing (rad) and distance (m) of all positions."""
        offset = self._rows[:, :2] - np.array([ego.x, ego.y])
        distance = np.hypot(offset[:, 0], offset[:, 1])
        bearing = np.arctan2(offset[:, 1], offset[:, 0]) - math.radians(ego.yaw_deg)
        bearing = np.arctan2(np.sin(bearing), np.cos(bearing))
        inside = (distance > NEAREST_M) & (distance < FARTHEST_M) & (np.abs(bearing) < CONE_RAD)
        return np.flatnonzero(inside), bearing, distance

    def _long_views(self) -> Floats:
        """Return each position's probability for the ego, from the amount of road far ahead and near the axis."""
        chances = np.zeros(len(self._rows))
        for k, (x, y, z, _, yaw, _) in enumerate(self._rows.tolist()):
            _, bearing, distance = self._seen(ActorPose(x, y, z, 0.0, yaw, 0.0))
            chances[k] = np.sum((distance > 90.0) & (distance < FARTHEST_M) & (np.abs(bearing) < AXIS_RAD / 2.0))
        chances = np.minimum(chances, 60.0) ** 2 + 1e-3
        return np.asarray(chances / chances.sum())

    def _filled(self, placed: list[ActorPose], total: int) -> list[ActorPose]:
        """Fill the list up to `total` poses with positions far away and apart from each other."""
        away = [ActorPose(AWAY_M + 20.0 * k, AWAY_M, 0.0, 0.0, 0.0, 0.0) for k in range(len(placed), total)]
        return [*placed, *away]
