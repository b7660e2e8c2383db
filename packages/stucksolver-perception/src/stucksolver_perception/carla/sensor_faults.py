"""Sensors that fail on purpose, to check that such a drive ends in waiting and asking, never in a collision."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stucksolver_perception.carla.sensor_suite import TickMeasurements
from stucksolver_perception.measurements import CameraFrame, LidarSweep
from stucksolver_perception.rig import CameraRig, load_rig

TURNED_RAD = math.radians(2.0)
SALTED = 0.05
"""Share of the lens that is covered."""
GRAIN_PX = 24
"""Size of a grain on the image: it is on the lens, far out of focus."""
SMEAR_AT, SMEAR_SIZE = (0.6, 0.3), (0.2, 0.12)
"""Place (right, down) and half size of a smear of mud, in widths of the image: 13 % of it."""
SMEAR_RIM = 0.15
"""Share of its half size over which it grows thin."""
MUD = 40
"""Its brightness (0 to 255)."""
STRAY_POINTS = 400
"""Points of a sweep without an object, such as spray."""
STRAY_REACH_M = 30.0
JUMP_M = 8.0
"""Error of fixes after reflections between houses."""


class SensorFault:
    """Changes the measurements of each tick from `since_s` on. `camera` is the front one; None for the shipped rig's.

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
        self.kept: TickMeasurements | None = None
        """The last measurements before the fault began."""

    def after(self, measured: TickMeasurements, time_s: float) -> TickMeasurements:
        """Return a tick's measurements with the fault; `time_s` counts from the beginning of the drive."""
        if time_s < self._since_s:
            kept = self.kept
            picture = measured.picture or (None if kept is None else kept.picture)
            self.kept = replace(measured, picture=picture)
            return measured
        return self._change(self, measured)


def _lidar_missing(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    return replace(now, sweep=None, silent=(*now.silent, "LiDAR"))


def _lidar_frozen(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    """The same sweep repeatedly, each time as if it were new."""
    if now.sweep is None or fault.kept is None or fault.kept.sweep is None:
        return now
    return replace(now, sweep=LidarSweep(now.sweep.time_s, fault.kept.sweep.points))


def _lidar_turned(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    """Its mount has turned by two degrees."""
    if now.sweep is None:
        return now
    points = now.sweep.points.copy()
    c, n = math.cos(TURNED_RAD), math.sin(TURNED_RAD)
    x, y = points[:, 0].copy(), points[:, 1].copy()
    points[:, 0], points[:, 1] = c * x - n * y, n * x + c * y
    return replace(now, sweep=LidarSweep(now.sweep.time_s, points))


def _lidar_sparse(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    """Three lasers of four have failed."""
    if now.sweep is None:
        return now
    left = now.sweep.points[fault.random.random(len(now.sweep.points)) < 0.25]
    return replace(now, sweep=LidarSweep(now.sweep.time_s, left))


def _lidar_spray(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    if now.sweep is None:
        return now
    way = fault.random.uniform(-math.pi, math.pi, STRAY_POINTS)
    far = fault.random.uniform(2.0, STRAY_REACH_M, STRAY_POINTS)
    stray = np.stack([far * np.cos(way), far * np.sin(way), fault.random.uniform(0.0, 2.0, STRAY_POINTS)], axis=1)
    rows = np.concatenate([stray, np.full((STRAY_POINTS, 1), 0.1)], axis=1).astype(np.float32)
    return replace(now, sweep=LidarSweep(now.sweep.time_s, np.concatenate([now.sweep.points, rows])))


def _camera_missing(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    return replace(now, picture=None, silent=(*now.silent, "camera"))


def _camera_black(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    if now.picture is None:
        return now
    return replace(now, picture=CameraFrame(now.picture.time_s, np.zeros_like(now.picture.rgb)))


def _camera_frozen(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    if now.picture is None or fault.kept is None or fault.kept.picture is None:
        return now
    return replace(now, picture=CameraFrame(now.picture.time_s, fault.kept.picture.rgb))


def _camera_salted(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    """Gray grains, always at the same places."""
    if now.picture is None:
        return now
    rows, columns = now.picture.rgb.shape[:2]
    grid = np.random.default_rng(1).random((rows // GRAIN_PX + 1, columns // GRAIN_PX + 1)) < SALTED
    grains = np.kron(grid, np.ones((GRAIN_PX, GRAIN_PX), bool))[:rows, :columns]
    rgb = now.picture.rgb.copy()
    rgb[grains] = 200
    return replace(now, picture=CameraFrame(now.picture.time_s, rgb))


def _camera_turned(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    """Its mount has turned by two degrees: everything is seen further to the left. What it newly sees is unknown, so
    the picture's outermost column is repeated there.
    """
    if now.picture is None:
        return now
    rows, columns = now.picture.rgb.shape[:2]
    # Where a ray of the turned camera leaves the picture of the other one (a homography; Hartley and Zisserman 2004).
    aside = (columns / 2.0 - 0.5 - np.arange(columns)) / fault.focal_px
    ahead = math.cos(TURNED_RAD) + math.sin(TURNED_RAD) * aside
    left = (math.cos(TURNED_RAD) * aside - math.sin(TURNED_RAD)) / ahead
    column = np.clip(np.rint(columns / 2.0 - 0.5 - fault.focal_px * left).astype(np.int64), 0, columns - 1)
    down = (np.arange(rows)[:, None] - rows / 2.0 + 0.5) / ahead
    row = np.clip(np.rint(rows / 2.0 - 0.5 + down).astype(np.int64), 0, rows - 1)
    return replace(now, picture=CameraFrame(now.picture.time_s, now.picture.rgb[row, column]))


def _camera_muddy(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    """One dark smear with a soft rim, always at the same place."""
    if now.picture is None:
        return now
    rows, columns = now.picture.rgb.shape[:2]
    y, x = np.mgrid[0:rows, 0:columns].astype(np.float32) / columns
    from_middle = np.hypot((x - SMEAR_AT[0]) / SMEAR_SIZE[0], (y - SMEAR_AT[1]) / SMEAR_SIZE[1])
    thick = np.clip((1.0 - from_middle) / SMEAR_RIM + 0.5, 0.0, 1.0)[:, :, None]
    rgb = (1.0 - thick) * now.picture.rgb + thick * MUD
    return replace(now, picture=CameraFrame(now.picture.time_s, rgb.astype(np.uint8)))


def _gnss_missing(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    return replace(now, fix=None, silent=(*now.silent, "GNSS"))


def _gnss_jumping(fault: SensorFault, now: TickMeasurements) -> TickMeasurements:
    if now.fix is None:
        return now
    dx, dy = fault.random.normal(0.0, JUMP_M, 2)
    return replace(now, fix=replace(now.fix, x_m=now.fix.x_m + dx, y_m=now.fix.y_m + dy))


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
"""Each changes one tick's measurements."""
