"""What CARLA measures arrives in the frames of perception."""

from __future__ import annotations

import math
from types import SimpleNamespace

import carla
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_perception.carla.sensor_conversion import (
    STOPPED_MPS,
    camera_rgb,
    imu_sample,
    lidar_points,
    wheel_speed_mps,
)
from stucksolver_perception.carla.sensor_mounting import carla_transform
from stucksolver_perception.rig import SensorMount

FLIP = np.diag([1.0, -1.0, 1.0, 1.0])
"""Between CARLA's axes (y right) and ours (y left)."""


def swept(*rows):
    return SimpleNamespace(raw_data=np.array(rows, np.float32).tobytes())


def felt(acceleration=(0.0, 0.0, 0.0), turning=(0.0, 0.0, 0.0), compass=0.0):
    return SimpleNamespace(
        accelerometer=carla.Vector3D(*acceleration), gyroscope=carla.Vector3D(*turning), compass=compass
    )


def test_lidar_points_right_of_sensor_are_right_at_mount_height():
    """A point to the right of the sensor is to the right of the ego, as high as the mount."""
    points = lidar_points(swept([10.0, 2.0, -1.0, 0.5]), SensorMount(x_m=1.0, y_m=0.0, z_m=2.5).to_vehicle())
    assert points.tolist() == [[11.0, -2.0, 1.5, 0.5]]


def test_lidar_points_of_left_turned_sensor_are_left():
    """A sensor that is turned to the left has ahead of it what is on the ego's left."""
    turned = SensorMount(x_m=0.0, y_m=0.0, z_m=0.0, yaw_deg=90.0)
    points = lidar_points(swept([10.0, 0.0, 0.0, 1.0]), turned.to_vehicle())
    assert points[0, :3].tolist() == pytest.approx([0.0, 10.0, 0.0], abs=1e-5)


def test_a_sweep_without_points_is_empty():
    assert lidar_points(SimpleNamespace(raw_data=b""), np.eye(4)).shape == (0, 4)


@given(
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.floats(-180.0, 180.0),
    st.floats(-80.0, 80.0),
    st.floats(-180.0, 180.0),
)
def test_carla_puts_a_sensor_where_the_rig_says(place, yaw, pitch, roll):
    x, y, z = place
    mount = SensorMount(x_m=x, y_m=y, z_m=z, yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll)
    carlas = np.array(carla_transform(mount).get_matrix())
    np.testing.assert_allclose(FLIP @ carlas @ FLIP, mount.to_vehicle(), atol=1e-5)


def test_imu_sample_left_turn_and_acceleration_are_positive():
    sample = imu_sample(felt((1.0, -2.0, 9.75), (0.125, 0.25, -0.5)), 3.0)
    assert sample.time_s == 3.0
    assert sample.acceleration_mps2 == (1.0, 2.0, 9.75)
    assert sample.rotation_rps == (-0.125, 0.25, 0.5)


@pytest.mark.parametrize(("compass_deg", "yaw_deg"), [(0.0, 90.0), (90.0, 0.0), (180.0, -90.0), (300.0, 150.0)])
def test_north_is_the_local_y_and_east_its_x(compass_deg, yaw_deg):
    sample = imu_sample(felt(compass=math.radians(compass_deg)), 0.0)
    assert math.degrees(sample.compass_rad) == pytest.approx(yaw_deg)


def test_a_picture_is_red_green_blue():
    blue, green, red = 1, 2, 3
    raw = np.array([[[blue, green, red, 255], [blue, green, red, 255]]], np.uint8)
    rgb = camera_rgb(SimpleNamespace(raw_data=raw.tobytes(), height=1, width=2))
    assert rgb.tolist() == [[[red, green, blue]] * 2]


def test_wheels_that_stand_count_nothing():
    assert wheel_speed_mps(STOPPED_MPS / 2.0, 5.0, np.random.default_rng(0)) == 0.0


def test_wheel_speed_error_matches_rig_in_reverse():
    """Turning wheels have the error that the rig states, in reverse too."""
    random = np.random.default_rng(0)
    off = np.array([wheel_speed_mps(-3.0, 0.05, random) + 3.0 for _ in range(2000)])
    assert abs(off.mean()) < 0.005
    assert off.std() == pytest.approx(0.05, rel=0.1)


def test_wheel_speed_noise_is_independent_of_earlier_stop():
    stood, drove = np.random.default_rng(4), np.random.default_rng(4)
    wheel_speed_mps(0.0, 0.05, stood)
    wheel_speed_mps(9.0, 0.05, drove)
    assert wheel_speed_mps(5.0, 0.05, stood) == wheel_speed_mps(5.0, 0.05, drove)
