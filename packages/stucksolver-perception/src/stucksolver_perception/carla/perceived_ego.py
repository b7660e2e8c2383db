"""Describes the perceived ego with the part of `carla.Vehicle` that `EgoVehicle` and the drivers use."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import carla

if TYPE_CHECKING:
    from stucksolver_perception.carla.ego_perception import EgoPerception
    from stucksolver_perception.carla.perceived_world import PerceivedWorld


class PerceivedEgo:
    """The perceived ego. Pose and motion are estimates; size, wheels and lamps are known exactly."""

    def __init__(self, vehicle: carla.Vehicle, perception: EgoPerception, world: PerceivedWorld) -> None:
        self._vehicle, self._perception, self._world = vehicle, perception, world
        self.id = int(vehicle.id)
        self.bounding_box = vehicle.bounding_box
        self.perceiver = perception
        """Perception from which drivers read objects instead of the client's ground truth."""

    def get_world(self) -> Any:
        """Return the perceived world."""
        return self._world

    def get_location(self) -> carla.Location:
        """Return the location of the reference point, at the height of the road."""
        pose = self._perception.pose
        return carla.Location(pose.x_m, -pose.y_m, pose.z_m)

    def get_transform(self) -> carla.Transform:
        """Return location and heading; pitch and roll are zero."""
        return carla.Transform(self.get_location(), carla.Rotation(yaw=-math.degrees(self._perception.pose.yaw_rad)))

    def get_velocity(self) -> carla.Vector3D:
        """Return the velocity along the heading, from the wheels (m/s)."""
        pose = self._perception.pose
        along, across = pose.speed_mps * math.cos(pose.yaw_rad), pose.speed_mps * math.sin(pose.yaw_rad)
        return carla.Vector3D(along, -across, 0.0)

    def get_angular_velocity(self) -> carla.Vector3D:
        """Return the angular velocity from the IMU (degrees/s, CARLA's sign)."""
        return carla.Vector3D(0.0, 0.0, -math.degrees(self._perception.pose.yaw_rate_rps))

    def get_physics_control(self) -> Any:
        """Return the physics control, with wheels and axles."""
        return self._vehicle.get_physics_control()

    def get_speed_limit(self) -> float:
        """Return the speed limit (km/h) from the client, because CARLA and carlette have it in no map."""
        return float(self._vehicle.get_speed_limit())

    def get_light_state(self) -> Any:
        """Return the ego's lamps."""
        return self._vehicle.get_light_state()

    def set_light_state(self, light_state: Any, /) -> None:
        """Switch the ego's lamps."""
        self._vehicle.set_light_state(light_state)

    def is_at_traffic_light(self) -> bool:
        """Return False, because lights are found by their stop lines on the map."""
        return False

    def get_traffic_light(self) -> None:
        """Return None; see `is_at_traffic_light`."""
