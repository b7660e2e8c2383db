"""The ego as its own sensors tell of it: what `EgoVehicle` and the drivers ask of a `carla.Vehicle`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import carla

if TYPE_CHECKING:
    from stucksolver.stacks.sensed.eyes import Eyes
    from stucksolver.stacks.sensed.world import SensedWorld


class SensedVehicle:
    """Place and motion are estimates; size, wheels and lamps are the vehicle's own, which it knows of itself."""

    def __init__(self, vehicle: carla.Vehicle, eyes: Eyes, world: SensedWorld) -> None:
        self._vehicle, self._eyes, self._world = vehicle, eyes, world
        self.id = int(vehicle.id)
        self.bounding_box = vehicle.bounding_box
        self.perceiver = eyes
        """Drivers that look for bodies themselves ask this instead of the client."""

    def get_world(self) -> Any:
        """As sensed."""
        return self._world

    def get_location(self) -> carla.Location:
        """Of its reference point; its height is the road's."""
        pose = self._eyes.pose
        return carla.Location(pose.x_m, -pose.y_m, pose.z_m)

    def get_transform(self) -> carla.Transform:
        """Place and heading, upright."""
        return carla.Transform(self.get_location(), carla.Rotation(yaw=-math.degrees(self._eyes.pose.yaw_rad)))

    def get_velocity(self) -> carla.Vector3D:
        """Along the heading, by the wheels."""
        pose = self._eyes.pose
        along, across = pose.speed_mps * math.cos(pose.yaw_rad), pose.speed_mps * math.sin(pose.yaw_rad)
        return carla.Vector3D(along, -across, 0.0)

    def get_angular_velocity(self) -> carla.Vector3D:
        """Degrees per second, CARLA's sign, by the IMU."""
        return carla.Vector3D(0.0, 0.0, -math.degrees(self._eyes.pose.yaw_rate_rps))

    def get_physics_control(self) -> Any:
        """Wheels and axles."""
        return self._vehicle.get_physics_control()

    def get_speed_limit(self) -> float:
        """km/h. The client's: the limit of the lane is a fact of the map, which carlette and CARLA tell in this way."""
        return float(self._vehicle.get_speed_limit())

    def get_light_state(self) -> Any:
        """Its own lamps."""
        return self._vehicle.get_light_state()

    def set_light_state(self, light_state: Any, /) -> None:
        """Its own lamps."""
        self._vehicle.set_light_state(light_state)

    def is_at_traffic_light(self) -> bool:
        """Nobody tells it: lights are known by their stop lines on the map."""
        return False

    def get_traffic_light(self) -> None:
        """None, see `is_at_traffic_light`."""
