"""Creates the rig's sensors from CARLA's blueprints, and attaches them to a vehicle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import carla

from stucksolver_carla.perception_interface import SensorError
from stucksolver_perception.carla.georeference import EARTH_RADIUS_M
from stucksolver_perception.rig import CameraRig, Rig, SensorMount

REFERENCE_POINT = SensorMount(x_m=0.0, y_m=0.0, z_m=0.0)
"""The vehicle's reference point, with GNSS and IMU."""
SEEDS = 2**31
"""Number of seeds: a blueprint's `noise_seed` is a signed 32-bit integer, and larger seeds are taken modulo this."""


@dataclass(frozen=True)
class SensorSetup:
    """One sensor for attachment."""

    type_id: str
    """Id of the blueprint."""
    mount: SensorMount
    """Pose of the sensor in the vehicle frame."""
    attributes: Mapping[str, float]
    """Values of the blueprint's attributes, in CARLA's units."""


def lidar_setup(rig: Rig, seed: int) -> SensorSetup:
    """Return the setup of the LiDAR on the roof. The same seed loses the same points."""
    lidar = rig.lidar
    attributes = {
        "channels": lidar.channels,
        "range": lidar.range_m,
        "rotation_frequency": lidar.turns_per_s,
        "points_per_second": lidar.points_per_s,
        "upper_fov": lidar.upper_deg,
        "lower_fov": lidar.lower_deg,
        "atmosphere_attenuation_rate": lidar.attenuation_per_m,
        "dropoff_general_rate": lidar.dropoff_general,
        "dropoff_intensity_limit": lidar.dropoff_intensity_limit,
        "dropoff_zero_intensity": lidar.dropoff_zero_intensity,
        "noise_stddev": lidar.noise_m,
        "noise_seed": seed % SEEDS,
    }
    return SensorSetup("sensor.lidar.ray_cast", lidar.mount, attributes)


def camera_setup(camera: CameraRig, period_s: float, type_id: str = "sensor.camera.rgb") -> SensorSetup:
    """Return the setup of a camera with one image per period; `type_id` may be another type of camera."""
    attributes = {
        "image_size_x": camera.width_px,
        "image_size_y": camera.height_px,
        "fov": camera.fov_deg,
        "sensor_tick": period_s,
    }
    return SensorSetup(type_id, camera.mount, attributes)


def imu_setup(rig: Rig, seed: int) -> SensorSetup:
    """Return the setup of the IMU. The same seed gives the same noise."""
    noise = {f"noise_accel_stddev_{axis}": rig.imu_acceleration_noise_mps2 for axis in "xyz"}
    noise |= {f"noise_gyro_stddev_{axis}": rig.imu_rotation_noise_rps for axis in "xyz"}
    return SensorSetup("sensor.other.imu", REFERENCE_POINT, {**noise, "noise_seed": seed % SEEDS})


def gnss_setup(rig: Rig, seed: int) -> SensorSetup:
    """Return the setup of the GNSS receiver, with noise in degrees and meters. The same seed gives the same noise."""
    degrees = math.degrees(rig.gnss_noise_m / EARTH_RADIUS_M)
    noise = {"noise_lat_stddev": degrees, "noise_lon_stddev": degrees, "noise_alt_stddev": rig.gnss_noise_m}
    return SensorSetup("sensor.other.gnss", REFERENCE_POINT, {**noise, "noise_seed": seed % SEEDS})


def mount_sensor(vehicle: carla.Vehicle, setup: SensorSetup) -> carla.Sensor:
    """Attach a sensor to a vehicle, without a callback yet.

    Raises:
        SensorError: This simulator does not have the sensor.
    """
    world = vehicle.get_world()
    blueprints = list(world.get_blueprint_library().filter(setup.type_id))
    if not blueprints:
        raise SensorError(f"this simulator has no {setup.type_id}; use carlette, or CARLA 0.9.14 or later")
    blueprint = blueprints[0]
    for name, value in setup.attributes.items():
        if not blueprint.has_attribute(name):
            raise SensorError(
                f"{setup.type_id} of this simulator has no attribute {name}; use carlette, or CARLA 0.9.14 or later"
            )
        blueprint.set_attribute(name, str(value))
    return cast("carla.Sensor", world.spawn_actor(blueprint, carla_transform(setup.mount), attach_to=vehicle))


def carla_transform(mount: SensorMount) -> carla.Transform:
    """Return a mount as a `carla.Transform`, whose yaw is positive to the right and whose pitch is positive up.

    The roll has the same sign in both: the right side goes down.
    """
    return carla.Transform(
        carla.Location(mount.x_m, -mount.y_m, mount.z_m),
        carla.Rotation(pitch=-mount.pitch_deg, yaw=-mount.yaw_deg, roll=mount.roll_deg),
    )
