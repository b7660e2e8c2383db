"""Each fault changes what it says of a tick's measurements, from its time on, and nothing else."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from stucksolver_perception.carla.sensor_faults import (
    FAULTS,
    JUMP_M,
    MUD_BRIGHTNESS,
    SALT_SHARE,
    SMEAR_AT,
    STRAY_POINTS,
    STRAY_REACH_M,
    SensorFault,
)
from stucksolver_perception.carla.sensor_suite import TickMeasurements
from stucksolver_perception.measurements import CameraFrame, GnssFix, ImuSample, LidarSweep, WheelSpeed
from stucksolver_perception.rig import load_rig

CHANGES = {"lidar": "sweep", "camera": "picture", "gnss": "fix"}
"""The field of `TickMeasurements` by the first word of a fault's name."""
FROM_S = 1.0


def measured(time_s, picture=True):
    """Of one tick; all numbers differ from tick to tick."""
    random = np.random.default_rng(round(time_s * 100.0))
    points = random.uniform(-50.0, 50.0, (2000, 4)).astype(np.float32)
    rgb = random.integers(0, 150, (240, 320, 3), np.uint8)
    return TickMeasurements(
        sweep=LidarSweep(time_s, points),
        picture=CameraFrame(time_s, rgb) if picture else None,
        imu=ImuSample(time_s, (0.0, 0.0, 9.81), (0.0, 0.0, 0.0)),
        fix=GnssFix(time_s, 5.0 * time_s, 1.0, 0.0),
        wheels=WheelSpeed(time_s, 5.0),
    )


def failing(name, seed=0):
    """A fault that has seen a tick before it began, and what it makes of the first one after."""
    fault = SensorFault(name, FROM_S, seed)
    before, now = measured(0.95), measured(1.0)
    fault.after(before, 0.95)
    return before, now, fault.after(now, 1.0)


def is_same(first, other):
    """Field for field, arrays by their values."""
    if first is None or other is None:
        return first is other
    pairs = ((getattr(first, field.name), getattr(other, field.name)) for field in fields(first))
    return all(np.array_equal(a, b) for a, b in pairs)


@pytest.mark.parametrize("name", FAULTS)
def test_before_its_time_nothing_is_changed(name):
    now = measured(0.95)
    assert SensorFault(name, FROM_S).after(now, 0.95) is now


@pytest.mark.parametrize("name", FAULTS)
def test_the_sensor_it_names_changes_and_no_other(name):
    _, now, after = failing(name)
    changed = CHANGES[name.split("-")[0]]
    assert not is_same(getattr(now, changed), getattr(after, changed))
    for other in {"sweep", "picture", "imu", "fix", "wheels"} - {changed}:
        assert getattr(after, other) is getattr(now, other)


@pytest.mark.parametrize("name", FAULTS)
def test_what_was_measured_is_not_written_to(name):
    _, now, _ = failing(name)
    untouched = measured(1.0)
    assert all(is_same(getattr(now, item), getattr(untouched, item)) for item in ("sweep", "picture", "fix"))


@pytest.mark.parametrize("name", FAULTS)
def test_a_tick_without_measurements_passes(name):
    fault = SensorFault(name)
    nothing = TickMeasurements(sweep=None, picture=None, imu=None, fix=None, wheels=WheelSpeed(0.0, 0.0))
    after = fault.after(nothing, 0.0)
    assert (after.sweep, after.picture, after.fix) == (None, None, None)


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_repeats_for_the_same_seed(name):
    changed = CHANGES[name.split("-")[0]]
    assert is_same(getattr(failing(name, 5)[2], changed), getattr(failing(name, 5)[2], changed))


@pytest.mark.parametrize(
    ("name", "sensor", "field"),
    [("lidar-missing", "LiDAR", "sweep"), ("camera-missing", "camera", "picture"), ("gnss-missing", "GNSS", "fix")],
)
def test_a_missing_sensor_is_silent(name, sensor, field):
    _, _, after = failing(name)
    assert getattr(after, field) is None
    assert after.silent == (sensor,)


@pytest.mark.parametrize(
    ("name", "field", "data"), [("lidar-frozen", "sweep", "points"), ("camera-frozen", "picture", "rgb")]
)
def test_fault_frozen_sensor_repeats_last_data_with_new_time(name, field, data):
    before, now, after = failing(name)
    assert getattr(after, field).time_s == getattr(now, field).time_s
    assert np.array_equal(getattr(getattr(after, field), data), getattr(getattr(before, field), data))


def test_fault_frozen_camera_shows_last_available_image():
    """A frozen camera shows its last image even if there was none on the last tick."""
    fault, first = SensorFault("camera-frozen", FROM_S), measured(0.9)
    fault.after(first, 0.9)
    fault.after(measured(0.95, picture=False), 0.95)
    assert np.array_equal(fault.after(measured(1.0), 1.0).picture.rgb, first.picture.rgb)


def test_fault_turned_lidar_rotates_points_by_2_deg_left():
    """A turned LiDAR has all points two degrees farther left, at the same distance."""
    _, now, after = failing("lidar-turned")
    was, points = now.sweep.points.astype(float), after.sweep.points.astype(float)
    turned = np.angle((points[:, 0] + 1j * points[:, 1]) / (was[:, 0] + 1j * was[:, 1]))
    np.testing.assert_allclose(np.degrees(turned), 2.0, atol=1e-3)
    np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), np.hypot(was[:, 0], was[:, 1]), rtol=1e-5)
    assert np.array_equal(points[:, 2:], was[:, 2:])


def test_fault_sparse_lidar_keeps_quarter_of_points():
    _, now, after = failing("lidar-sparse")
    whole = {row.tobytes() for row in now.sweep.points}
    assert all(row.tobytes() in whole for row in after.sweep.points)
    assert len(after.sweep.points) / len(now.sweep.points) == pytest.approx(0.25, abs=0.05)


def test_spray_is_added_near_the_car_and_low():
    _, now, after = failing("lidar-spray")
    count = len(now.sweep.points)
    assert np.array_equal(after.sweep.points[:count], now.sweep.points)
    stray = after.sweep.points[count:]
    assert len(stray) == STRAY_POINTS
    assert np.hypot(stray[:, 0], stray[:, 1]).max() <= STRAY_REACH_M
    assert 0.0 <= stray[:, 2].min() <= stray[:, 2].max() <= 2.0


def test_a_black_camera_shows_nothing_at_all():
    _, now, after = failing("camera-black")
    assert after.picture.rgb.shape == now.picture.rgb.shape
    assert not after.picture.rgb.any()


def test_fault_salted_camera_covers_same_places():
    """Salt covers its share of the lens, always in the same places."""
    fault = SensorFault("camera-salted")
    masks = []
    for time_s in (1.0, 1.2):
        now = measured(time_s)
        after = fault.after(now, time_s).picture.rgb
        masks.append((after == 200).all(axis=2))
        assert np.array_equal(after[~masks[-1]], now.picture.rgb[~masks[-1]])
    assert np.array_equal(*masks)
    assert SALT_SHARE / 3.0 < masks[0].mean() < SALT_SHARE * 3.0


def test_a_turned_camera_sees_everything_two_degrees_to_the_left():
    """A thin post straight ahead, one ten degrees to the left, and one that leaves the picture."""
    camera = load_rig().camera
    half_px, focal_px = camera.width_px / 2.0, camera.focal_px
    rgb = np.zeros((camera.height_px, camera.width_px, 3), np.uint8)
    for bearing_deg, value in ((0.0, 100), (10.0, 200), (34.0, 250)):
        at = round(half_px - focal_px * math.tan(math.radians(bearing_deg)))
        rgb[:, at - 1 : at + 2] = value
    now = replace(measured(0.0), picture=CameraFrame(0.0, rgb))
    after = SensorFault("camera-turned", camera=camera).after(now, 0.0).picture.rgb
    assert after.shape == rgb.shape
    for bearing_deg, value in ((2.0, 100), (12.0, 200)):
        columns = np.flatnonzero(after[camera.height_px // 2, :, 0] == value)
        assert columns.mean() == pytest.approx(half_px - focal_px * math.tan(math.radians(bearing_deg)), abs=1.5)
    assert not (after == 250).any()


def test_mud_darkens_one_place_that_grows_clear_towards_its_rim():
    bright = replace(measured(1.0), picture=CameraFrame(1.0, np.full((240, 320, 3), 220, np.uint8)))
    gray = SensorFault("camera-muddy").after(bright, 1.0).picture.rgb[:, :, 0].astype(int)
    dark = np.argwhere(gray == MUD_BRIGHTNESS)
    assert dark.mean(axis=0) == pytest.approx([SMEAR_AT[1] * 320.0, SMEAR_AT[0] * 320.0], abs=1.0)
    assert 0.03 < (gray == MUD_BRIGHTNESS).mean() < (gray < 220).mean() < 0.15
    assert np.abs(np.diff(gray, axis=1)).max() < 40


def test_fixes_jump_about_the_truth_and_keep_their_height():
    fault = SensorFault("gnss-jumping")
    now, count = measured(0.0), 400
    fixes = [fault.after(now, 0.0).fix for _ in range(count)]
    off = np.array([(fix.x_m - now.fix.x_m, fix.y_m - now.fix.y_m, fix.z_m - now.fix.z_m) for fix in fixes])
    np.testing.assert_allclose(off[:, :2].std(axis=0), JUMP_M, rtol=0.15)
    assert np.abs(off[:, :2].mean(axis=0)).max() < 4.0 * JUMP_M / math.sqrt(count)
    assert not off[:, 2].any()


def test_an_unknown_fault_is_refused_with_those_there_are():
    with pytest.raises(
        ValueError, match=r"unknown sensor fault 'lidar-melted'; choose from lidar-missing, .*gnss-jumping"
    ):
        SensorFault("lidar-melted")
