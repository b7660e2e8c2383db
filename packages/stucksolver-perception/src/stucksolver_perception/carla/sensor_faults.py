"""Injects sensor faults, to check that such a run ends in waiting and questions, never in a collision."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stucksolver_perception.carla.sensor_suite import TickMeasurements
from stucksolver_perception.measurements import CameraFrame, LidarSweep
from stucksolver_perception.rig import CameraRig, load_rig

TURNED_RAD = math.radians(2.0)
"""Yaw error of a turned sensor (rad). Ours."""
SALT_SHARE = 0.05
"""Share of the lens that salt covers. Ours."""
GRAIN_PX = 24
"""Size of a grain in the image (px): it is on the lens, far out of focus. Ours."""
SMEAR_AT, SMEAR_SIZE = (0.6, 0.3), (0.2, 0.12)
"""Position (right, down) and half size of a smear of mud, in widths of the image: 13 % of it. Ours."""
SMEAR_RIM = 0.15
"""Share of the smear's half size over which it becomes transparent. Ours."""
MUD_BRIGHTNESS = 40
"""Brightness of the mud (0 to 255). Ours."""
STRAY_POINTS = 400
"""Number of points per sweep without an object, such as spray. Ours."""
STRAY_REACH_M = 30.0
"""Maximum range of these points (m). Ours."""
JUMP_M = 8.0
"""Standard deviation of fixes after reflections between houses (m). Ours."""


class SensorFault:
    """A fault that changes the measurements from `since_s` on. `camera` is the front one; None takes the shipped rig's.

    Raises:
        ValueError: The name of the fault is unknown.
    """

    def __init__(self, name: str, since_s: float = 0.0, seed: int = 0, camera: CameraRig | None = None) -> None:
        if name not in FAULTS:
            raise ValueError(f"unknown sensor fault {name!r}; choose from {', '.join(FAULTS)}")
        self._change = FAULTS[name]
        self._since_s = since_s
        self.focal_px = (camera or load_rig().camera).focal_px
        self.random = np.random.default_rng(seed)
        self.last_healthy: TickMeasurements | None = None
        """The last measurements before the fault started."""

    def after(self, measured: TickMeasurements, time_s: float) -> TickMeasurements:
        """Return a tick's measurements with the fault; `time_s` counts from the start of the run."""
        if time_s < self._since_s:
            last_healthy = self.last_healthy
            picture = measured.picture or (None if last_healthy is None else last_healthy.picture)
            self.last_healthy = replace(measured, picture=picture)
            return measured
        return self._change(self, measured)


def _lidar_missing(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    return replace(measured, sweep=None, silent=(*measured.silent, "LiDAR"))


def _lidar_frozen(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    """Repeat the same sweep, each time with a new time stamp."""
    if measured.sweep is None or fault.last_healthy is None or fault.last_healthy.sweep is None:
        return measured
    return replace(measured, sweep=LidarSweep(measured.sweep.time_s, fault.last_healthy.sweep.points))


def _lidar_turned(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    """Turn the LiDAR's mount by two degrees."""
    if measured.sweep is None:
        return measured
    points = measured.sweep.points.copy()
    c, n = math.cos(TURNED_RAD), math.sin(TURNED_RAD)
    x, y = points[:, 0].copy(), points[:, 1].copy()
    points[:, 0], points[:, 1] = c * x - n * y, n * x + c * y
    return replace(measured, sweep=LidarSweep(measured.sweep.time_s, points))


def _lidar_sparse(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    """Drop three points of four, as with failed lasers."""
    if measured.sweep is None:
        return measured
    points = measured.sweep.points[fault.random.random(len(measured.sweep.points)) < 0.25]
    return replace(measured, sweep=LidarSweep(measured.sweep.time_s, points))


def _lidar_spray(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    if measured.sweep is None:
        return measured
    azimuth = fault.random.uniform(-math.pi, math.pi, STRAY_POINTS)
    range_m = fault.random.uniform(2.0, STRAY_REACH_M, STRAY_POINTS)
    stray = np.stack(
        [range_m * np.cos(azimuth), range_m * np.sin(azimuth), fault.random.uniform(0.0, 2.0, STRAY_POINTS)], axis=1
    )
    rows = np.concatenate([stray, np.full((STRAY_POINTS, 1), 0.1)], axis=1).astype(np.float32)
    return replace(measured, sweep=LidarSweep(measured.sweep.time_s, np.concatenate([measured.sweep.points, rows])))


def _camera_missing(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    return replace(measured, picture=None, silent=(*measured.silent, "camera"))


def _camera_black(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    if measured.picture is None:
        return measured
    return replace(measured, picture=CameraFrame(measured.picture.time_s, np.zeros_like(measured.picture.rgb)))


def _camera_frozen(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    if measured.picture is None or fault.last_healthy is None or fault.last_healthy.picture is None:
        return measured
    return replace(measured, picture=CameraFrame(measured.picture.time_s, fault.last_healthy.picture.rgb))


def _camera_salted(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    """Add gray grains, always at the same positions."""
    if measured.picture is None:
        return measured
    rows, columns = measured.picture.rgb.shape[:2]
    grid = np.random.default_rng(1).random((rows // GRAIN_PX + 1, columns // GRAIN_PX + 1)) < SALT_SHARE
    grains = np.kron(grid, np.ones((GRAIN_PX, GRAIN_PX), bool))[:rows, :columns]
    rgb = measured.picture.rgb.copy()
    rgb[grains] = 200
    return replace(measured, picture=CameraFrame(measured.picture.time_s, rgb))


def _camera_turned(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    """Turn the camera's mount by two degrees, so that all objects are farther to the left in the image.

    The newly visible part is unknown, so the image's outermost column is repeated there.
    """
    if measured.picture is None:
        return measured
    rows, columns = measured.picture.rgb.shape[:2]
    # The column and row in the original image of each ray of the turned camera (a homography; Hartley and Zisserman
    # 2004).
    offset = (columns / 2.0 - 0.5 - np.arange(columns)) / fault.focal_px
    depth = math.cos(TURNED_RAD) + math.sin(TURNED_RAD) * offset
    points = (math.cos(TURNED_RAD) * offset - math.sin(TURNED_RAD)) / depth
    column = np.clip(np.rint(columns / 2.0 - 0.5 - fault.focal_px * points).astype(np.int64), 0, columns - 1)
    row_offset = (np.arange(rows)[:, None] - rows / 2.0 + 0.5) / depth
    row = np.clip(np.rint(rows / 2.0 - 0.5 + row_offset).astype(np.int64), 0, rows - 1)
    return replace(measured, picture=CameraFrame(measured.picture.time_s, measured.picture.rgb[row, column]))


def _camera_muddy(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    """Add one dark smear with a soft rim, always at the same position."""
    if measured.picture is None:
        return measured
    rows, columns = measured.picture.rgb.shape[:2]
    y, x = np.mgrid[0:rows, 0:columns].astype(np.float32) / columns
    from_center = np.hypot((x - SMEAR_AT[0]) / SMEAR_SIZE[0], (y - SMEAR_AT[1]) / SMEAR_SIZE[1])
    opacity = np.clip((1.0 - from_center) / SMEAR_RIM + 0.5, 0.0, 1.0)[:, :, None]
    rgb = (1.0 - opacity) * measured.picture.rgb + opacity * MUD_BRIGHTNESS
    return replace(measured, picture=CameraFrame(measured.picture.time_s, rgb.astype(np.uint8)))


def _gnss_missing(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    return replace(measured, fix=None, silent=(*measured.silent, "GNSS"))


def _gnss_jumping(fault: SensorFault, measured: TickMeasurements) -> TickMeasurements:
    if measured.fix is None:
        return measured
    dx, dy = fault.random.normal(0.0, JUMP_M, 2)
    return replace(measured, fix=replace(measured.fix, x_m=measured.fix.x_m + dx, y_m=measured.fix.y_m + dy))


FAULTS: dict[str, Callable[[SensorFault, TickMeasurements], TickMeasurements]] = {
    "lidar-missing": _lidar_missing,
    "lidar-frozen": _lidar_frozen,
    "lidar-turned": _lidar_turned,
    "lidar-sparse": _lidar_sparse,
    "lidar-spray": _lidar_spray,
    "camera-missing": _camera_missing,
    "camera-black": _camera_black,
    "camera-frozen": _camera_frozen,
    "camera-salted": _camera_salted,
    "camera-turned": _camera_turned,
    "camera-muddy": _camera_muddy,
    "gnss-missing": _gnss_missing,
    "gnss-jumping": _gnss_jumping,
}
"""The functions that change one tick's measurements, by the fault's name."""
