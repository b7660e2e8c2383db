"""What of the rig CARLA's blueprints are told."""

from __future__ import annotations

import math

import pytest

from stucksolver_carla.perception_interface import SensorError
from stucksolver_perception.carla.georeference import EARTH_RADIUS_M
from stucksolver_perception.carla.sensor_mounting import (
    SEEDS,
    camera_setup,
    gnss_setup,
    imu_setup,
    lidar_setup,
    mount_sensor,
)
from stucksolver_perception.rig import load_rig

RIG = load_rig()


def test_gnss_setup_altitude_noise_equals_position_noise():
    told = gnss_setup(RIG, 0).attributes
    assert told["noise_alt_stddev"] == RIG.gnss_noise_m
    for axis in ("lat", "lon"):
        # A degree is as long as at the equator; the map's scale makes it shorter elsewhere.
        assert math.radians(told[f"noise_{axis}_stddev"]) * EARTH_RADIUS_M == pytest.approx(RIG.gnss_noise_m)


@pytest.mark.parametrize("setup", [imu_setup, gnss_setup, lidar_setup])
def test_noise_differs_by_seed_and_repeats_for_the_same_one(setup):
    assert setup(RIG, 7) == setup(RIG, 7)
    assert setup(RIG, 7).attributes["noise_seed"] != setup(RIG, 8).attributes["noise_seed"]


@pytest.mark.parametrize("seed", [-1, 2**31, 2**63 + 5])
def test_any_seed_fits_into_the_blueprints_attribute(seed):
    assert 0 <= imu_setup(RIG, seed).attributes["noise_seed"] < SEEDS


def test_camera_setups_share_mount_and_lens():
    picture, instances = (
        camera_setup(RIG.camera, 0.5),
        camera_setup(RIG.camera, 0.5, "sensor.camera.instance_segmentation"),
    )
    assert (picture.mount, picture.attributes) == (instances.mount, instances.attributes)
    assert picture.attributes["fov"] == RIG.camera.fov_deg
    assert picture.type_id != instances.type_id


def test_the_lidar_is_the_rigs_where_the_rig_has_it():
    setup = lidar_setup(RIG, 0)
    assert setup.mount == RIG.lidar.mount
    assert setup.attributes["channels"] == RIG.lidar.channels
    assert setup.attributes["noise_stddev"] == RIG.lidar.noise_m


class Blueprint:
    """A blueprint without attributes."""

    def has_attribute(self, name):
        return False


class Vehicle:
    """A vehicle in a world with these blueprints."""

    def __init__(self, *blueprints):
        self.blueprints = blueprints

    def get_world(self):
        return self

    def get_blueprint_library(self):
        return self

    def filter(self, pattern):
        return self.blueprints


def test_mount_sensor_missing_sensor_is_named_with_remedy():
    with pytest.raises(SensorError, match=r"no sensor\.other\.imu; use carlette, or CARLA"):
        mount_sensor(Vehicle(), imu_setup(RIG, 0))


def test_mount_sensor_missing_attribute_is_named():
    with pytest.raises(SensorError, match=r"sensor\.lidar\.ray_cast .* no attribute channels; use carlette"):
        mount_sensor(Vehicle(Blueprint()), lidar_setup(RIG, 0))
