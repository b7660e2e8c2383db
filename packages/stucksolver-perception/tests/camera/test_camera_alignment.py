"""A front camera that is turned is noticed by the ends of what the LiDAR sees; one that is not is never accused."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from tests.lidar.scanner import scan

from stucksolver_perception.camera.camera_miscalibration import AGREEING, MEASUREMENTS, CameraAlignment
from stucksolver_perception.measurements import CameraFrame, Floats, LidarSweep, PoseEstimate, Singles
from stucksolver_perception.rig import CameraRig, load_rig

RIG = load_rig()
RIG = RIG.model_copy(update={"camera": RIG.camera.model_copy(update={"width_px": 800, "height_px": 450})})
PLACES = MEASUREMENTS + 4
"""At which it is measured whether the camera is turned."""
PICTURES = 3
"""Pictures for each measurement, of other things each time."""


def pose(time_s: float, speed_mps: float = 8.0) -> PoseEstimate:
    return PoseEstimate(time_s, 0.0, 0.0, 0.0, 0.0, speed_mps, 0.0, np.eye(4))


def things(seed: int) -> Floats:
    """(n, 7): posts, huts and cars at both sides of a road."""
    random = np.random.default_rng([7, seed])
    boxes = []
    for _ in range(14):
        x, y = random.uniform(10.0, 42.0), random.choice([-1.0, 1.0]) * random.uniform(3.0, 12.0)
        size = [(0.3, 0.3, 5.0), (4.5, 1.9, 1.6), (6.0, 5.0, 4.0)][random.integers(3)]
        boxes.append((x, y, size[2] / 2.0, *size, random.uniform(-0.3, 0.3)))
    return np.array(boxes)


def painted(boxes: Floats, camera: CameraRig, seed: int, noise: float = 4.0) -> CameraFrame:
    """A picture of boxes before the sky, each in one brightness, from the furthest to the nearest."""
    random = np.random.default_rng([8, seed])
    rgb = np.empty((camera.height_px, camera.width_px, 3))
    rgb[: camera.height_px // 2], rgb[camera.height_px // 2 :] = 200.0, 90.0
    for box in boxes[np.argsort(-boxes[:, 0])]:
        cos, sin = math.cos(box[6]), math.sin(box[6])
        corners = np.array([(a, b, c) for a in (-0.5, 0.5) for b in (-0.5, 0.5) for c in (-0.5, 0.5)]) * box[3:6]
        at = np.column_stack([cos * corners[:, 0] - sin * corners[:, 1], sin * corners[:, 0] + cos * corners[:, 1]])
        column, row, ahead = camera.project(np.column_stack([at, corners[:, 2]]) + box[:3])
        if ahead.min() < 1.0:
            continue
        left, right = (int(np.clip(item, 0, camera.width_px)) for item in (column.min(), column.max()))
        top, foot = (int(np.clip(item, 0, camera.height_px)) for item in (row.min(), row.max()))
        rgb[top:foot, left:right] = random.uniform(20.0, 180.0)
    rgb += random.normal(0.0, noise, rgb.shape)
    return CameraFrame(0.0, np.clip(rgb, 0.0, 255.0).astype(np.uint8))


@cache
def scanned(seed: int, time_s: float) -> Singles:
    return scan(things(seed), time_s, seed).points


def sweeps(boxes: Floats, seed: int, lidar_turned_deg: float = 0.0) -> list[tuple[LidarSweep, PoseEstimate]]:
    """A turn of a LiDAR that is turned to the left."""
    told = []
    for time_s in (0.0, 0.05):
        points = scanned(seed, time_s).copy() if len(boxes) else scan(boxes, time_s).points
        way = -math.radians(lidar_turned_deg)
        turning = np.array([[math.cos(way), -math.sin(way)], [math.sin(way), math.cos(way)]], np.float32)
        points[:, :2] = points[:, :2] @ turning.T
        told.append((LidarSweep(time_s, points), pose(time_s)))
    return told


def turned(camera: CameraRig, turned_deg: float) -> CameraRig:
    return camera.model_copy(update={"mount": camera.mount.model_copy(update={"yaw_deg": turned_deg})})


def driven(
    turned_deg: float, lidar_turned_deg: float = 0.0, places: int = PLACES
) -> tuple[CameraAlignment, list[float]]:
    """Look around at some places; also returns what single measurements said (degrees)."""
    alignment, said = CameraAlignment(RIG), []
    for place in range(places):
        for seed in range(PICTURES * place, PICTURES * (place + 1)):
            boxes = things(seed)
            frame = painted(boxes, turned(RIG.camera, turned_deg), seed)
            alignment.look(frame, pose(0.05), sweeps(boxes, seed, lidar_turned_deg))
        angle = alignment.measure(math.radians(lidar_turned_deg))
        said += [] if angle is None else [math.degrees(angle)]
    return alignment, said


@pytest.mark.integration
@pytest.mark.parametrize("turned_deg", [2.0, -2.0, 1.6, -3.4])
def test_a_turned_camera_is_noticed_and_its_angle_is_told(turned_deg: float) -> None:
    alignment, _ = driven(turned_deg)
    assert alignment.turned_rad is not None
    assert math.degrees(alignment.turned_rad) == pytest.approx(turned_deg, abs=0.3)


@pytest.mark.integration
def test_a_healthy_camera_is_not_accused() -> None:
    alignment, said = driven(0.0)
    assert alignment.turned_rad is None
    assert len(said) >= AGREEING
    assert abs(float(np.median(said))) < 0.3


@pytest.mark.integration
@pytest.mark.parametrize("lidar_turned_deg", [2.0, -3.0])
def test_a_turned_lidar_does_not_accuse_a_healthy_camera(lidar_turned_deg: float) -> None:
    alignment, said = driven(0.0, lidar_turned_deg)
    assert alignment.turned_rad is None
    assert abs(float(np.median(said))) < 0.3


@pytest.mark.integration
def test_camera_alignment_camera_and_lidar_both_turned_is_detected() -> None:
    """A camera that is turned together with the LiDAR is detected."""
    alignment, _ = driven(2.0, 2.0)
    assert alignment.turned_rad is not None
    assert math.degrees(alignment.turned_rad) == pytest.approx(2.0, abs=0.3)


def test_a_few_measurements_are_not_enough() -> None:
    assert driven(2.0, places=AGREEING - 1)[0].turned_rad is None


@pytest.mark.parametrize("kind", ["noise", "gray"])
def test_a_picture_that_shows_nothing_says_nothing(kind: str) -> None:
    random = np.random.default_rng(0)
    alignment = CameraAlignment(RIG)
    for place in range(3 * PLACES):
        shape = RIG.camera.height_px, RIG.camera.width_px, 3
        rgb = random.integers(0, 255, shape, np.uint8) if kind == "noise" else np.full(shape, 99, np.uint8)
        alignment.look(CameraFrame(0.0, rgb), pose(0.05), sweeps(things(place), place))
        alignment.measure(0.0)
        assert alignment.turned_rad is None


def test_an_empty_road_says_nothing() -> None:
    alignment = CameraAlignment(RIG)
    for place in range(PLACES):
        nothing = np.zeros((0, 7))
        alignment.look(painted(things(place), RIG.camera, place), pose(0.05), sweeps(nothing, place))
        assert alignment.measure(0.0) is None


def test_camera_alignment_stopped_vehicle_measures_nothing() -> None:
    """A stopped vehicle does not measure the same scene again and again."""
    alignment, boxes = CameraAlignment(RIG), things(0)
    for _ in range(PLACES):
        alignment.look(painted(boxes, turned(RIG.camera, 2.0), 0), pose(0.05, 0.0), sweeps(boxes, 0))
        assert alignment.measure(0.0) is None


def test_sweeps_of_long_ago_are_not_compared() -> None:
    alignment, boxes = CameraAlignment(RIG), things(0)
    alignment.look(painted(boxes, RIG.camera, 0), pose(3.0), sweeps(boxes, 0))
    assert alignment.measure(0.0) is None
