"""Data that no working sensor gives are not believed, and what is wrong is said; healthy data pass."""

from __future__ import annotations

import numpy as np
import pytest

from stucksolver_perception.measurements import CameraFrame, LidarSweep
from stucksolver_perception.rig import load_rig
from stucksolver_perception.sensor_health import MIN_POINT_SHARE, SAME_PICTURES, SAME_SWEEPS, SensorHealth

RIG = load_rig().lidar
TICK_S = 0.05
CAST = round(RIG.points_per_s * TICK_S)
NOISE = np.random.default_rng(0)


@pytest.fixture
def health():
    return SensorHealth(RIG, TICK_S)


def sweep(share=0.5):
    """A new one of a flat road, with points for this share of the rays."""
    points = NOISE.uniform(-50.0, 50.0, (round(share * CAST), 4)).astype(np.float32)
    points[:, 2] = 0.0
    return LidarSweep(0.0, points)


def drops(count, reach_m=30.0):
    """Returns from the air, (count, 4)."""
    way, far = NOISE.uniform(-np.pi, np.pi, count), NOISE.uniform(2.0, reach_m, count)
    at = (far * np.cos(way), far * np.sin(way), NOISE.uniform(0.3, 2.0, count), np.full(count, 0.1))
    return np.stack(at, axis=1).astype(np.float32)


def wall(x_m):
    """A wall across the road, (n, 4), seen as densely as a LiDAR with 64 channels sees it at `x_m`."""
    y, z = np.meshgrid(np.arange(-2.0, 2.0, 0.0065 * x_m), np.arange(0.3, 2.0, 0.011 * x_m))
    at = (np.full(y.size, x_m), y.ravel(), z.ravel(), np.full(y.size, 0.8))
    rows = np.stack(at, axis=1).astype(np.float32)
    return rows[NOISE.random(len(rows)) < 0.5]  # half of the returns are lost, as the rig says


def picture(low=0, high=255):
    """A new one of this brightness."""
    return CameraFrame(0.0, NOISE.integers(low, high, (90, 160, 3), np.uint8))


def test_healthy_data_pass_as_they_are(health):
    for _ in range(20):
        points, shown = sweep(), picture()
        assert health.sweep(points) is points
        assert health.picture(shown, moves=True) is shown
    assert health.faults == ()


def test_a_night_with_some_lamps_is_no_fault(health):
    dark = picture(0, 6)
    dark.rgb[40:50, 60:90] = 250
    assert health.picture(dark, moves=True) is dark


@pytest.mark.parametrize(("low", "high"), [(0, 1), (120, 121)], ids=["black", "gray"])
def test_an_empty_picture_is_not_believed(health, low, high):
    assert health.picture(picture(low, high), moves=False) is None
    assert health.faults == ("the camera's image is black or empty",)


def test_health_same_image_while_moving_is_rejected(health):
    frozen = picture()
    believed = [health.picture(frozen, moves=True) is not None for _ in range(SAME_PICTURES + 3)]
    assert believed == [True] * SAME_PICTURES + [False] * 3
    assert health.faults == ("the camera repeats the same image",)


def test_health_same_image_while_stopped_is_accepted(health):
    frozen = picture()
    assert all(health.picture(frozen, moves=False) is frozen for _ in range(10 * SAME_PICTURES))


def test_health_images_changing_while_moving_are_accepted(health):
    """Images of a car that stops and goes are accepted as long as they change while it moves."""
    standing = picture()
    for _ in range(10):
        assert all(health.picture(standing, moves=False) for _ in range(5))
        standing = picture()
        assert health.picture(standing, moves=True) is standing


def test_each_camera_is_judged_by_its_own_pictures(health):
    same = picture()
    for _ in range(SAME_PICTURES + 1):
        assert health.picture(picture(), moves=True) is not None
        held = health.picture(same, moves=True, camera="rear camera")
    assert held is None
    assert health.faults == ("the rear camera repeats the same image",)


def test_a_silent_lidar_is_named(health):
    assert health.sweep(None) is None
    assert health.faults == ("the LiDAR gives no data",)


def test_health_sparse_sweep_is_rejected_with_point_count(health):
    """A sparse sweep is rejected, and its points are counted."""
    few = sweep(0.5 * MIN_POINT_SHARE)
    assert health.sweep(few) is None
    assert health.faults == (f"the LiDAR gives {len(few.points)} points for {CAST} rays",)


def test_health_sweep_with_just_enough_points_is_accepted(health):
    enough = sweep(1.1 * MIN_POINT_SHARE)
    assert health.sweep(enough) is enough


def test_a_sweep_that_comes_again_and_again_is_not_believed(health):
    frozen = sweep()
    believed = [health.sweep(LidarSweep(TICK_S * k, frozen.points)) is not None for k in range(SAME_SWEEPS + 3)]
    assert believed == [True] * SAME_SWEEPS + [False] * 3
    assert health.faults == ("the LiDAR repeats the same points",)


def test_a_sensor_that_works_again_is_believed_at_once(health):
    frozen = sweep()
    for _ in range(SAME_SWEEPS + 1):
        health.sweep(frozen)
    health.picture(picture(0, 1), moves=True)
    assert len(health.faults) == 2
    assert health.sweep(sweep()) is not None
    assert health.picture(picture(), moves=True) is not None
    assert health.faults == ()


def test_spray_is_removed_and_said_and_bodies_stay(health):
    body = np.concatenate([wall(5.0), wall(12.0), wall(25.0)])
    road, wet = sweep().points, drops(180)
    kept = health.sweep(LidarSweep(0.0, np.concatenate([road, body, wet]))).points
    assert np.array_equal(kept[: len(road)], road)
    bodies = {row.tobytes() for row in body}
    left = sum(row.tobytes() in bodies for row in kept)
    assert left > 0.99 * len(body)
    assert len(kept) - len(road) - left < 0.1 * len(wet)
    assert [fault[-33:] for fault in health.faults] == ["% of the LiDAR's points are spray"]


@pytest.mark.parametrize("amount", [400, 1000, 3000])
def test_air_that_is_full_of_spray_is_not_believed(health, amount):
    for _ in range(3):
        assert health.sweep(LidarSweep(0.0, np.concatenate([sweep().points, wall(12.0), drops(amount)]))) is None
    assert health.faults[0].endswith("are spray, too many")
    assert health.sweep(sweep()) is not None
    assert health.faults == ()


def test_a_sweep_without_a_return_above_the_road_is_clear(health):
    """Also one far body with single returns: in clear air nothing is removed."""
    lone = LidarSweep(0.0, np.concatenate([sweep().points, drops(20)]))
    assert health.sweep(lone) is lone


def test_health_turned_lidar_is_rejected_until_run_ends(health):
    """Sweeps of a turned LiDAR are rejected until the run ends."""
    health.turned("LiDAR", None)
    assert health.sweep(sweep()) is not None
    health.turned("LiDAR", np.radians(-2.04))
    for _ in range(5):
        health.turned("LiDAR", None)  # a vehicle that stands measures nothing
        assert health.sweep(sweep()) is None
    assert health.faults == ("the LiDAR seems turned by 2.0 degrees to the right",)
    assert health.picture(picture(), moves=True) is not None


def test_health_turned_camera_is_rejected_and_others_are_not(health):
    """Images of a turned camera are rejected, and those of other sensors are not."""
    health.turned("camera", np.radians(1.97))
    assert health.picture(picture(), moves=True) is None
    assert health.faults == ("the camera seems turned by 2.0 degrees to the left",)
    assert health.picture(picture(), moves=True, camera="rear camera") is not None
    assert health.sweep(sweep()) is not None


def test_a_turned_lidar_that_falls_silent_is_called_silent(health):
    health.turned("LiDAR", 0.04)
    health.sweep(None)
    assert health.faults == ("the LiDAR gives no data",)
