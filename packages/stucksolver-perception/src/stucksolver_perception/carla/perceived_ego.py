"""The ego as its own sensors see it: the part of `carla.Vehicle` that `EgoVehicle` and the drivers use."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import carla

if TYPE_CHECKING:
    from stucksolver_perception.carla.ego_perception import EgoPerception
    from stucksolver_perception.carla.perceived_world import PerceivedWorld


class PerceivedEgo:
    """Pose and motion are estimates; size, wheels and lamps are known exactly."""

    def __init__(self, vehicle: carla.Vehicle, eyes: EgoPerception, world: PerceivedWorld) -> None:
        self._vehicle, self._eyes, self._world = vehicle, eyes, world
        self.id = int(vehicle.id)
        self.bounding_box = vehicle.bounding_box
        self.perceiver = eyes
        """Perception that drivers use instead of the client when they look for bodies."""

    def get_world(self) -> Any:
        """The world, as sensed."""
        return self._world

    def get_location(self) -> carla.Location:
        """Location of its reference point; the height is that of the road."""
        pose = self._eyes.pose
        return carla.Location(pose.x_m, -pose.y_m, pose.z_m)

    def get_transform(self) -> carla.Transform:
        """Location and heading; pitch and roll are zero."""
        return carla.Transform(self.get_location(), carla.Rotation(yaw=-math.degrees(self._eyes.pose.yaw_rad)))

    def get_velocity(self) -> carla.Vector3D:
        """Velocity along the heading, from the wheels (m/s)."""
        pose = self._eyes.pose
        along, across = pose.speed_mps * math.cos(pose.yaw_rad), pose.speed_mps * math.sin(pose.yaw_rad)
        return carla.Vector3D(along, -across, 0.0)

    def get_angular_velocity(self) -> carla.Vector3D:
        """Angular velocity from the IMU (degrees/s, CARLA's sign)."""
        return carla.Vector3D(0.0, 0.0, -math.degrees(self._eyes.pose.yaw_rate_rps))

    def get_physics_control(self) -> Any:
        """Physics control, with wheels and axles."""
        return self._vehicle.get_physics_control()

    def get_speed_limit(self) -> float:
        """Speed limit (km/h), from the client: it is a fact of the map that CARLA and carlette provide only this
        way.
        """
        return float(self._vehicle.get_speed_limit())

    def get_light_state(self) -> Any:
        """Its own lamps."""
        return self._vehicle.get_light_state()

    def set_light_state(self, light_state: Any, /) -> None:
        """Its own lamps."""
        self._vehicle.set_light_state(light_state)

    def is_at_traffic_light(self) -> bool:
        """Always False: lights are known by their stop lines on the map."""
        return False

    def get_traffic_light(self) -> None:
        """Always None, see `is_at_traffic_light`."""
