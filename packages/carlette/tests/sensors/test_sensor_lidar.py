"""What the LiDARs send: sweeps, channels, intensity, losses and noise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mounting import ON_ROOF_M, Mounted, lidar_points, mount, street

from carlette.errors import RequestError
from carlette.geometry import Pose, Rotation, Vector
from straight import add

EXACT = {"dropoff_general_rate": 0, "dropoff_zero_intensity": 0}
DENSE = {"channels": 16, "points_per_second": 16 * 720 * 20, "rotation_frequency": 20, "range": 50}
PLACE = Pose(Vector(100.0, 1.75, ON_ROOF_M))


@pytest.fixture(scope="module")
def world():
    world = street()
    world.tick()
    return world


def rows(one: Mounted) -> np.ndarray:
    return lidar_points(one.body())[2]


def test_lidar_ticks_sweep_consecutive_sectors(world) -> None:
    """A tick sweeps its sector of a turn, and the next one continues at its end."""
    one = mount(world, "sensor.lidar.ray_cast", PLACE, **EXACT, **DENSE | {"rotation_frequency": 5, "lower_fov": -20})
    spans = []
    for number in range(1, 5):
        angle, counts, points = lidar_points(one.body())
        assert angle == pytest.approx(number % 4 * math.pi / 2, abs=1e-5)
        assert counts.sum() == len(points) and len(counts) == 16
        azimuth = np.degrees(np.arctan2(points[:, 1], points[:, 0]))
        spans.append((azimuth.min(), azimuth.max()))
    assert np.array(spans) == pytest.approx(np.array([(-180, -90), (-90, 0), (0, 90), (90, 180)]), abs=1.0)


def test_lidar_channels_are_evenly_spaced_between_limits(world) -> None:
    """The channels are evenly spaced in elevation from the upper to the lower limit."""
    one = mount(world, "sensor.lidar.ray_cast", PLACE, **EXACT, **DENSE | {"upper_fov": -10, "lower_fov": -40})
    _, counts, points = lidar_points(one.body())
    elevation = np.degrees(np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1])))
    for channel, part in enumerate(np.split(elevation, np.cumsum(counts)[:-1])):
        assert part == pytest.approx(np.full(len(part), -10.0 - 2.0 * channel), abs=1e-3)


def test_lidar_road_height_is_exact_and_intensity_fades(world) -> None:
    """The points of the road have its height, and the intensity fades with the distance."""
    one = mount(world, "sensor.lidar.ray_cast", PLACE, **EXACT, **DENSE)
    points = rows(one)
    across = points[:, 1] + 1.75
    road = points[np.abs(across) < 3.4]
    assert len(road) > 1000
    assert road[:, 2] == pytest.approx(np.full(len(road), -ON_ROOF_M), abs=2e-3)
    distance = np.linalg.norm(points[:, :3], axis=1)
    assert points[:, 3] == pytest.approx(np.exp(-0.004 * distance), rel=1e-4)
    assert distance.max() <= 50.0


def test_sidewalks_lie_a_kerb_higher(world) -> None:
    points = rows(mount(world, "sensor.lidar.ray_cast", PLACE, **EXACT, **DENSE))
    across = points[:, 1] + 1.75
    walk = points[(across > 3.8) & (across < 6.8)]
    assert np.median(walk[:, 2]) == pytest.approx(0.15 - ON_ROOF_M, abs=2e-3)


@pytest.mark.integration
def test_a_rising_road_is_seen_rising() -> None:
    world = street(slope=0.1)
    world.tick()
    place = Pose(Vector(100.0, 1.75, 10.0 + ON_ROOF_M))
    points = rows(mount(world, "sensor.lidar.ray_cast", place, **EXACT, **DENSE))
    road = points[np.abs(points[:, 1] + 1.75) < 3.4]
    assert road[:, 2] == pytest.approx(0.1 * road[:, 0] - ON_ROOF_M, abs=5e-3)


@pytest.mark.parametrize("tilt", [Rotation(0, 40, 0), Rotation(20, 0, 0), Rotation(-10, 70, 25)])
def test_points_are_in_the_sensors_own_frame(world, tilt: Rotation) -> None:
    one = mount(world, "sensor.lidar.ray_cast", Pose(PLACE.location, tilt), **EXACT, **DENSE)
    pose = one.world.pose(one.actor)
    found = np.array([pose.apply(Vector(*map(float, row[:3]))) for row in rows(one)[::7]])
    road = found[np.abs(found[:, 1]) < 3.4]
    assert len(road) > 100
    assert np.abs(road[:, 2]).max() < 5e-3


def test_the_share_that_is_asked_for_is_lost(world) -> None:
    def count(**attributes: object) -> int:
        return len(rows(mount(world, "sensor.lidar.ray_cast", PLACE, **(DENSE | EXACT | attributes))))

    every = count()
    assert count(dropoff_general_rate=0.45) / every == pytest.approx(0.55, abs=0.02)
    # With an intensity of e^(-0.2 d): what is below the limit is kept by 1 - 0.4 + 0.4 / 0.8 intensity.
    faded = count(atmosphere_attenuation_rate=0.2, dropoff_zero_intensity=0.4, dropoff_intensity_limit=0.8)
    points = rows(mount(world, "sensor.lidar.ray_cast", PLACE, **EXACT, **DENSE, atmosphere_attenuation_rate=0.2))
    kept = np.where(points[:, 3] > 0.8, 1.0, 0.6 + 0.5 * points[:, 3])
    assert faded == pytest.approx(kept.sum(), rel=0.02)


def test_noise_moves_points_along_their_rays_by_its_deviation(world) -> None:
    exact = rows(mount(world, "sensor.lidar.ray_cast", PLACE, **EXACT, **DENSE))[:, :3]
    noisy = rows(mount(world, "sensor.lidar.ray_cast", PLACE, **EXACT, **DENSE, noise_stddev=0.1))[:, :3]
    length = np.linalg.norm(exact, axis=1)
    off = (noisy * exact).sum(axis=1) / length - length
    assert off.mean() == pytest.approx(0.0, abs=0.01) and off.std() == pytest.approx(0.1, rel=0.05)
    assert np.abs(np.cross(noisy, exact)).max() < 0.05  # none aside


def test_a_semantic_point_tells_angle_actor_and_tag(world) -> None:
    car = add(world, x=110.0)
    one = mount(world, "sensor.lidar.ray_cast_semantic", PLACE, **DENSE)
    points = lidar_points(one.body(), 6)[2]
    world.remove(car.id)
    ids, tags = (points[:, i].copy().view(np.uint32) for i in (4, 5))
    assert set(ids.tolist()) == {0, car.id}
    assert set(tags[ids == car.id].tolist()) == {14}
    assert {1, 2, 10} <= set(tags[ids == 0].tolist())
    road = (tags == 1) & (np.abs(points[:, 1] + 1.75) < 3.4)
    distance = np.linalg.norm(points[:, :3], axis=1)
    assert points[road, 3] == pytest.approx(ON_ROOF_M / distance[road], abs=1e-3)
    inside = world_box(points[ids == car.id, :3], car)
    assert inside.all()


def world_box(points: np.ndarray, car) -> np.ndarray:
    """Which points of the sensor at `PLACE` lie in the true box of a car at 110 m; mirrors stand out a little."""
    gap = points + np.array(PLACE.location) - np.array([110.0, 1.75, 0.0]) - np.array(car.box.center)
    return (np.abs(gap) - np.array(car.box.extent) <= np.array([0.03, 0.15, 0.06])).all(axis=1)


def test_a_sensor_inside_its_car_looks_out_of_it(world) -> None:
    car = add(world, x=300.0)
    one = mount(world, "sensor.lidar.ray_cast", Pose(Vector(0.0, 0.0, 1.1)), car.id, **EXACT, **DENSE)
    points = rows(one)
    world.remove(car.id)
    assert np.linalg.norm(points[:, :3], axis=1).max() > 20.0


@pytest.mark.parametrize(
    ("name", "value"),
    [("channels", "0"), ("channels", "1e9"), ("range", "nan"), ("points_per_second", "many"), ("upper_fov", "170")],
)
def test_an_attribute_out_of_its_range_is_refused_by_name(world, name: str, value: str) -> None:
    with pytest.raises(RequestError, match=rf"'{name}' is '{value}'; give a"):
        mount(world, "sensor.lidar.ray_cast", PLACE, **{name: value})


def test_no_points_asked_for_gives_an_empty_message(world) -> None:
    angle, counts, points = lidar_points(mount(world, "sensor.lidar.ray_cast", PLACE, points_per_second=0).body())
    assert (angle, counts.sum(), len(points)) == (pytest.approx(math.pi), 0, 0)


def test_lidar_same_seed_loses_same_points_for_any_actor() -> None:
    """The same seed loses the same points, whichever actor id the LiDAR has."""
    losing = {"dropoff_general_rate": 0.45, "noise_stddev": 0.1}
    bodies = [mount(street(), "sensor.lidar.ray_cast", noise_seed=seed, **losing).body() for seed in (7, 7, 8)]
    world = street()
    mount(world, "sensor.other.gnss")
    later = mount(world, "sensor.lidar.ray_cast", noise_seed=7, **losing)
    assert bodies[0] == bodies[1] == later.body() != bodies[2]
