"""GNSS and IMU: truth, frames and noise."""

from __future__ import annotations

import math

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mounting import Mounted, mount, street

from carlette.geometry import Pose, Rotation, Vector
from carlette.sensors.gnss import GeoPoint, geo_point, map_reference
from carlette.world.world import World
from straight import add, drive, launch

carla = pytest.importorskip("carla")
GRAVITY = 9.81


@pytest.fixture(scope="module")
def world() -> World:
    return street()


def imu(one: Mounted) -> tuple[np.ndarray, np.ndarray, float]:
    acceleration, turning, compass = msgpack.unpackb(one.body())
    return np.array(acceleration), np.array(turning), compass


@given(st.floats(-5000, 5000), st.floats(-5000, 5000), st.floats(-70, 70), st.floats(-170, 170))
def test_places_are_those_of_the_client_librarys_map(x: float, y: float, latitude: float, longitude: float) -> None:
    """The 0.9.16 library has the sign of the northing wrong (CARLA issue 9389), so it is asked for the mirrored y."""
    text = "<OpenDRIVE><header><geoReference>+proj=tmerc +lat_0=0 +lon_0=0</geoReference></header></OpenDRIVE>".replace(
        "lat_0=0", f"lat_0={latitude!r}"
    ).replace("lon_0=0", f"lon_0={longitude!r}")
    origin = map_reference(text)
    assert (origin.latitude, origin.longitude) == (latitude, longitude)
    found = geo_point(origin, Vector(x, y, 3.0))
    assert found.altitude_m == 3.0
    # Near the origin, a degree of latitude is the same everywhere and one of longitude shrinks with the cosine.
    meter = math.degrees(1.0 / 6378137.0)
    assert found.latitude - latitude == pytest.approx(-y * meter, rel=0.01, abs=1e-9)
    assert found.longitude - longitude == pytest.approx(
        x * meter / math.cos(math.radians(latitude)), rel=1e-6, abs=1e-9
    )


def test_at_the_towns_reference_it_agrees_with_the_client(world: World) -> None:
    theirs = world.roads.map.transform_to_geolocation(carla.Location(120.0, 30.0, 2.0))
    ours = geo_point(map_reference(world.roads.file.text), Vector(120.0, 30.0, 2.0))
    assert (abs(theirs.latitude), theirs.longitude, theirs.altitude) == pytest.approx(
        (abs(ours.latitude), ours.longitude, 2.0), rel=5e-4
    )  # 0.9.16 scales by 1 / 0.9996, whatever the map's k is
    assert ours.latitude < 0.0  # y points south


def test_a_map_without_reference_lies_at_zero() -> None:
    assert map_reference("<OpenDRIVE><header/></OpenDRIVE>") == GeoPoint(0.0, 0.0, 0.0)


def test_gnss_noise_has_configured_bias_and_deviation(world: World) -> None:
    """The noise of the GNSS has the bias and the standard deviation that were set."""
    one = mount(world, "sensor.other.gnss", noise_lat_bias=0.5, noise_lat_stddev=0.01, noise_alt_stddev=2.0)
    found = np.array([msgpack.unpackb(one.body()) for _ in range(3000)])
    assert found.mean(axis=0) == pytest.approx([0.5, 0.0, 0.0], abs=0.15)
    assert found[:, 0].mean() == pytest.approx(0.5, abs=1e-3)
    assert found.std(axis=0) == pytest.approx([0.01, 0.0, 2.0], rel=0.05)


@pytest.mark.parametrize("type_id", ["sensor.other.gnss", "sensor.other.imu"])
def test_sensor_noise_is_reproducible_by_seed(world: World, type_id: str) -> None:
    """The same seed gives the same noise, and another seed gives other noise."""
    noise = {"noise_lat_stddev": 1} if type_id.endswith("gnss") else {"noise_gyro_stddev_x": 1}
    first, same, other = (mount(world, type_id, noise_seed=seed, **noise) for seed in (7, 7, 8))
    drawn = [[item.body() for _ in range(5)] for item in (first, same, other)]
    assert drawn[0] == drawn[1] != drawn[2]


def test_at_rest_the_imu_feels_what_holds_it_up(world: World) -> None:
    for rotation, held in (
        (Rotation(), (0, 0, GRAVITY)),
        (Rotation(pitch=90), (GRAVITY, 0, 0)),
        (Rotation(roll=90), (0, -GRAVITY, 0)),
    ):
        one = mount(world, "sensor.other.imu", Pose(Vector(), rotation))
        for _ in range(3):
            world.elapsed_s += 0.05
            acceleration, turning, _ = imu(one)
        assert acceleration == pytest.approx(held, abs=1e-6)
        assert turning == pytest.approx([0, 0, 0], abs=1e-9)


@pytest.mark.parametrize(("yaw", "north_east"), [(-90, 0.0), (0, math.pi / 2), (90, math.pi), (180, 1.5 * math.pi)])
def test_the_compass_counts_from_north_over_east(world: World, yaw: float, north_east: float) -> None:
    assert imu(mount(world, "sensor.other.imu", Pose(Vector(), Rotation(yaw=yaw))))[2] == pytest.approx(north_east)


def test_imu_braking_acceleration_follows_mount_orientation() -> None:
    """The IMU measures braking as a backward acceleration, and as a lateral one if it is mounted sideways."""
    for yaw, axis, sign in ((0.0, 0, -1.0), (90.0, 1, 1.0)):
        world = street()
        car = add(world, x=50.0)
        one = mount(world, "sensor.other.imu", Pose(Vector(0, 0, 1), Rotation(yaw=yaw)), car.id)
        launch(world, car, 15.0)
        for _ in range(12):
            drive(world, car, brake=1.0)
            world.tick()
            acceleration, _, _ = imu(one)
        expected = float(world.bodies.acceleration[car.row, 0])
        assert expected < -5.0
        assert acceleration[axis] == pytest.approx(sign * abs(expected), rel=0.1)


def test_imu_in_bend_measures_yaw_rate_and_centripetal_acceleration() -> None:
    """In a bend, the gyroscope measures the yaw rate, and an IMU 20 m ahead a higher acceleration."""
    world = street()
    car = add(world, x=50.0)
    middle, front = (mount(world, "sensor.other.imu", Pose(Vector(x, 0, 1)), car.id) for x in (0.0, 20.0))
    launch(world, car, 6.0)
    for _ in range(20):
        drive(world, car, throttle=0.3, steer=0.3)
        world.tick()
        (near, turning, _), (far, _, _) = imu(middle), imu(front)
    rate = math.radians(world.bodies.angular[car.row, 2])
    assert turning[2] == pytest.approx(rate, rel=0.05) and rate > 0.1
    assert near[1] > 0.5  # to the right
    assert near[0] - far[0] == pytest.approx(20.0 * rate**2, rel=0.3)


def test_imu_noise_has_the_deviation_that_was_set(world: World) -> None:
    one = mount(world, "sensor.other.imu", noise_accel_stddev_z=0.5, noise_gyro_stddev_y=0.2, noise_gyro_bias_y=0.1)
    world.elapsed_s += 0.05
    found = [imu(one) for _ in range(3000) if (setattr(world, "elapsed_s", world.elapsed_s + 0.05)) is None]
    accelerations, turnings = np.array([item[0] for item in found]), np.array([item[1] for item in found])
    assert accelerations.std(axis=0) == pytest.approx([0, 0, 0.5], abs=0.03)
    assert accelerations.mean(axis=0) == pytest.approx([0, 0, GRAVITY], abs=0.05)
    assert turnings.mean(axis=0) == pytest.approx([0, 0.1, 0], abs=0.02)
    assert turnings.std(axis=0) == pytest.approx([0, 0.2, 0], abs=0.02)
