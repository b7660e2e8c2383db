"""The rig's sensors on a car that stands on the embedded simulator: what they say of it is true."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
import pytest
from townstage import Stage

from stucksolver_carla.perception_interface import SensorError
from stucksolver_carla.stack.carla_frames import to_local, yaw_to_local
from stucksolver_eval.simulator_server import carlette_server
from stucksolver_perception.carla import sensor_suite as suites
from stucksolver_perception.carla.sensor_mounting import camera_setup, lidar_setup
from stucksolver_perception.carla.sensor_suite import SensorSuite
from stucksolver_perception.rig import load_rig

pytestmark = pytest.mark.integration

FULL = load_rig()
RIG = FULL.model_copy(update={"camera": FULL.camera.model_copy(update={"width_px": 320, "height_px": 180})})
"""Pictures of the full size take long to draw, and show no more of what is tested."""
PLACE = (3, -1, 100.0)
TICKS = 6


@pytest.fixture(scope="module")
def seen() -> Iterator[Stage]:
    """A world whose cameras and rays measure from their first tick on, and nobody in it but a car that stands."""
    with carlette_server("demo_town", scenery=True) as server:
        stage = Stage(server.host, server.port)
        stage.add("vehicle.tesla.model3", PLACE, role="hero")
        stage.ticks(40)
        yield stage
        stage.clear()


@pytest.fixture(scope="module")
def measured(seen):
    """Six ticks of a suite, and where the car was meanwhile."""
    return readings(seen, seed=3)


def readings(stage, seed=0, count=TICKS, **more):
    suite = SensorSuite(stage.actors[0], stage.map, RIG, seed=seed, **more)
    try:
        found = []
        for _ in range(count):
            stage.world.tick()
            found.append(suite.read())
        return found
    finally:
        suite.close()
        stage.world.tick()


def fixes(found):
    return np.array([(item.fix.x_m, item.fix.y_m, item.fix.z_m) for item in found])


def test_suite_sensors_report_each_tick_and_camera_when_due(measured):
    """Every sensor reports on every tick, and the camera when it is due."""
    assert [item.silent for item in measured] == [()] * TICKS
    assert all(item.sweep and item.imu and item.fix for item in measured)
    assert [item.picture is not None for item in measured] == [True, False, False, False, True, False]


def test_suite_camera_period_not_multiple_of_tick_is_awaited(seen):
    """A camera whose period is no multiple of the tick is waited for when it is due."""
    found = readings(seen, count=9, picture_period_s=0.12)
    assert [i for i, item in enumerate(found) if item.picture is not None] == [0, 3, 5, 8]
    assert not any(item.silent for item in found)


def test_fixes_lie_about_the_truth_in_height_too(seen, measured):
    location = seen.actors[0].get_transform().location
    off = fixes(measured) - (*to_local(location), location.z)
    assert np.abs(off).max() < 4.0 * RIG.gnss_noise_m
    assert np.abs(off.mean(axis=0)).max() < 4.0 * RIG.gnss_noise_m / TICKS**0.5
    assert off.std(axis=0).min() > 0.2 * RIG.gnss_noise_m


def test_the_compass_is_the_cars_heading(seen, measured):
    yaw = yaw_to_local(seen.actors[0].get_transform().rotation.yaw)
    off = [np.angle(np.exp(1j * (item.imu.compass_rad - yaw))) for item in measured]
    assert np.abs(off).max() < 0.01


def test_suite_stopped_vehicle_measures_gravity_without_motion(measured):
    """A stopped vehicle measures gravity, no rotation and no wheel speed."""
    felt = np.array([item.imu.acceleration_mps2 for item in measured])
    np.testing.assert_allclose(felt, [[0.0, 0.0, 9.81]] * TICKS, atol=0.1)
    assert np.abs([item.imu.rotation_rps for item in measured]).max() < 0.01
    assert [item.wheels.speed_mps for item in measured] == [0.0] * TICKS


def test_the_road_around_the_car_lies_at_height_zero(measured):
    points = np.concatenate([item.sweep.points for item in measured])
    lane = (np.abs(points[:, 1]) < 1.5) & (np.abs(points[:, 0]) > 5.0) & (np.abs(points[:, 0]) < 15.0)
    assert lane.sum() > 500
    assert abs(np.median(points[lane, 2])) < 0.05
    assert np.abs(points[lane, 2]).max() < 0.3


def test_suite_image_has_rig_size_and_sky_above_road(measured):
    rgb = measured[0].picture.rgb
    assert (rgb.shape, rgb.dtype) == ((RIG.camera.height_px, RIG.camera.width_px, 3), np.uint8)
    red, _, blue = rgb[:20].reshape(-1, 3).mean(axis=0)
    assert blue > red


def test_noise_repeats_for_the_same_seed_and_differs_for_another(seen, measured):
    np.testing.assert_allclose(fixes(readings(seen, seed=3)), fixes(measured), atol=1e-3)
    assert np.abs(fixes(readings(seen, seed=4)) - fixes(measured)).max() > 0.1


def test_suite_without_waiting_slow_reader_gets_new_data(seen):
    """In a world that does not wait, a slow reader gets new data.

    The tick of a fix is identified by its noise.
    """
    known, missed = fixes(readings(seen, seed=5, count=12)), 12
    suite = SensorSuite(seen.actors[0], seen.map, RIG, seed=5, waits=False)
    seen.ticks(missed)
    time.sleep(1.0)
    found = fixes([suite.read()])
    suite.close()
    seen.world.tick()
    of = int(np.abs(known - found).max(axis=1).argmin())
    assert np.abs(known[of] - found).max() < 1e-3
    assert missed - 1 - of <= suites.MAX_LATE_TICKS


def test_a_suite_takes_its_sensors_with_it(seen):
    readings(seen)
    assert not list(seen.world.get_actors().filter("sensor.*"))


def other(part, **fields):
    return RIG.model_copy(update={part: getattr(RIG, part).model_copy(update=fields)})


def test_a_lidar_of_another_channel_count_is_named(seen, monkeypatch):
    monkeypatch.setattr(suites, "lidar_setup", lambda rig, seed: lidar_setup(other("lidar", channels=32), seed))
    with pytest.raises(SensorError, match=r"LiDAR has 32 channels, the rig has 64: give the rig file"):
        readings(seen)


def test_a_picture_of_another_size_is_named(seen, monkeypatch):
    narrow = other("camera", width_px=160).camera
    monkeypatch.setattr(suites, "camera_setup", lambda camera, every_s: camera_setup(narrow, every_s))
    with pytest.raises(SensorError, match=r"image is 160 x 180, the rig has 320 x 180: give the rig file"):
        readings(seen)
