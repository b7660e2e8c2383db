"""What CARLA measures arrives in the frames of perception."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stucksolver.perception.rig import Mount
from stucksolver_eval.recording.geodetic import EARTH_RADIUS_M, GeoReference
from stucksolver_eval.recording.mounted import imu_row, instance_ids, lidar_points, placed


def test_a_point_to_the_right_of_the_sensor_is_to_our_right_and_as_high_as_the_mount() -> None:
    raw = np.array([[10.0, 2.0, -1.0, 0.5]], np.float32).tobytes()
    points = lidar_points(raw, Mount(x_m=1.0, y_m=0.0, z_m=2.5).to_vehicle())
    assert points.tolist() == [[11.0, -2.0, 1.5, 0.5]]


def test_a_sensor_turned_to_the_left_sees_ahead_of_it_what_is_on_our_left() -> None:
    raw = np.array([[10.0, 0.0, 0.0, 1.0]], np.float32).tobytes()
    points = lidar_points(raw, Mount(x_m=0.0, y_m=0.0, z_m=0.0, yaw_deg=90.0).to_vehicle())
    assert points[0, :3].tolist() == pytest.approx([0.0, 10.0, 0.0], abs=1e-5)


def test_a_mount_turned_left_and_down_is_so_in_carlas_signs() -> None:
    there = placed(Mount(x_m=1.0, y_m=0.5, z_m=2.0, yaw_deg=30.0, pitch_deg=10.0))
    assert (there.location.x, there.location.y, there.location.z) == (1.0, -0.5, 2.0)
    assert (there.rotation.yaw, there.rotation.pitch) == (-30.0, -10.0)


def test_a_turn_to_the_left_is_positive_and_so_is_acceleration_to_the_left() -> None:
    row = imu_row((1.0, -2.0, 9.8), (0.1, 0.2, -0.3), 0.0)
    assert row[:6].tolist() == [1.0, 2.0, 9.8, -0.1, 0.2, 0.3]


@pytest.mark.parametrize(("compass_deg", "yaw_deg"), [(0.0, 90.0), (90.0, 0.0), (180.0, -90.0), (300.0, 150.0)])
def test_north_is_the_local_y_and_east_its_x(compass_deg: float, yaw_deg: float) -> None:
    row = imu_row((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), math.radians(compass_deg))
    assert math.degrees(row[6]) == pytest.approx(yaw_deg)


def test_an_id_is_green_and_256_times_blue() -> None:
    blue, green, red = 2, 7, 99
    raw = np.array([[[blue, green, red, 255]]], np.uint8).tobytes()
    assert instance_ids(raw, 1, 1).tolist() == [[2 * 256 + 7]]


def test_a_degree_north_of_the_equator_is_a_degree_of_the_earths_circle() -> None:
    x, y = GeoReference("<OpenDRIVE/>").local(0.001, 0.002)
    degree_m = math.radians(1.0) * EARTH_RADIUS_M
    assert (x, y) == (pytest.approx(0.002 * degree_m), pytest.approx(0.001 * degree_m, rel=1e-6))


def test_the_maps_own_origin_is_the_local_origin() -> None:
    reference = "<geoReference><![CDATA[+proj=tmerc +lat_0=49.0 +lon_0=8.4]]></geoReference>"
    assert GeoReference(reference).local(49.0, 8.4) == (0.0, 0.0)
    x, _ = GeoReference(reference).local(49.0, 8.401)
    assert x == pytest.approx(math.radians(0.001) * math.cos(math.radians(49.0)) * EARTH_RADIUS_M)
