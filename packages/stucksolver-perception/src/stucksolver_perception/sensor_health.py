"""Checks that the sensors' data are plausible, and drops the others, so that the guard rejects plans on old data."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from stucksolver_perception.camera.lens_dirt import LensMonitor
from stucksolver_perception.lidar.spray import SPRAY, THICK, isolated_points
from stucksolver_perception.measurements import CameraFrame, LidarSweep, Pixels, PoseEstimate
from stucksolver_perception.rig import LidarRig

MIN_BRIGHTNESS = 3.0
"""Minimum mean brightness of an image (0 to 255). At night, lamps and sky give more. Ours."""
MIN_CONTRAST = 2.0
"""Minimum standard deviation of the brightness in an image (0 to 255). Ours."""
SAME_PICTURES = 3
"""Number of repetitions of an image after which the camera is frozen, while the vehicle moves. Simulated cameras have
no noise, so that a stopped vehicle proves nothing. Ours."""
SAME_SWEEPS = 4
"""Number of repetitions of a sweep after which the LiDAR is frozen; lost rays are random. Ours."""
MIN_POINT_SHARE = 0.15
"""Minimum number of points of a sweep, as a share of its rays. Fewer come from a failing sensor. Ours."""
SAMPLE_STEP = 16
"""Distance of the pixels of an image that are compared (px). Ours."""


@dataclass
class SensorHealth:
    """Checks of all sensors of a vehicle. `faults` has the present faults."""

    rig: LidarRig
    tick_s: float = 0.05
    """Duration of a tick, in which a sweep is measured (s)."""
    lenses: dict[str, LensMonitor] = field(default_factory=dict)
    """The monitors of lenses, by camera. A lens without a monitor counts as clean."""
    _pictures: dict[str, tuple[Pixels, int]] = field(default_factory=dict)
    """The last image's sample and its number of repetitions, by camera."""
    _sweep: tuple[int, float] | None = None
    """Number of points of the last sweep, and the sum of their coordinates."""
    _sweeps: int = 0
    """Number of repetitions of the last sweep."""
    _turned: dict[str, str] = field(default_factory=dict)
    """The fault texts of turned sensors, by sensor."""
    _faults: dict[str, str] = field(default_factory=dict)
    """The present faults, by sensor."""

    @property
    def faults(self) -> tuple[str, ...]:
        """The faults, in a few words each."""
        return tuple(self._faults.values())

    def sweep(self, sweep: LidarSweep | None) -> LidarSweep | None:
        """Return the sweep without spray, or None if it is not plausible."""
        reason = self._sweep_fault(sweep) or self._turned.get("LiDAR", "")
        self._set_fault("LiDAR", reason)
        return None if reason or sweep is None else self._without_spray(sweep)

    def _without_spray(self, sweep: LidarSweep) -> LidarSweep | None:
        isolated = isolated_points(sweep.points)
        share = float(isolated.mean())
        if share <= SPRAY:
            return sweep
        too_many = ", too many" if share > THICK else ""
        self._set_fault("LiDAR", f"{share:.1%} of the LiDAR's points are spray{too_many}")
        return None if share > THICK else replace(sweep, points=sweep.points[~isolated])

    def turned(self, sensor: str, turned_rad: float | None) -> None:
        """Store the yaw error of a sensor, positive to the left; None has no effect. Its data are dropped from then on.

        This holds until the end of the run. Without sweeps the vehicle brakes, and only a moving vehicle can measure
        the angle again. A broken mount does not repair itself. If the data were used again after a while, the vehicle
        would drive some tens of meters with wrong data each time, until the angle is measured again.
        """
        if turned_rad is not None:
            angle, side = math.degrees(abs(turned_rad)), "left" if turned_rad > 0.0 else "right"
            self._turned[sensor] = f"the {sensor} seems turned by {angle:.1f} degrees to the {side}"

    def fixes(self, doubted: bool) -> None:
        """Store whether the satellite fixes contradict each other."""
        self._set_fault("GNSS", "the GNSS fixes contradict each other" if doubted else "")

    def picture(
        self, frame: CameraFrame, moves: bool, camera: str = "camera", pose: PoseEstimate | None = None
    ) -> CameraFrame | None:
        """Return the image with the detected dirt on the lens, or None if it is not plausible.

        Args:
            frame: The image.
            moves: True if the vehicle moves.
            camera: Name of the camera.
            pose: The vehicle's pose at the time of the image. Without it, the lens is not checked.
        """
        reason = self._picture_fault(frame, moves, camera) or self._turned.get(camera, "")
        lens = self.lenses.get(camera)
        if reason or lens is None:
            self._set_fault(camera, reason)
            return None if reason else frame
        checked, dirt = lens.checked(frame, pose if moves else None, camera)
        self._set_fault(camera, dirt)
        return checked

    def _sweep_fault(self, sweep: LidarSweep | None) -> str:
        if sweep is None:
            return "the LiDAR gives no data"
        rays = self.rig.points_per_s * self.tick_s
        if len(sweep.points) < MIN_POINT_SHARE * rays:
            return f"the LiDAR gives {len(sweep.points)} points for {rays:.0f} rays"
        fingerprint = (len(sweep.points), float(sweep.points[:, :3].sum(dtype=np.float64)))
        self._sweeps = self._sweeps + 1 if fingerprint == self._sweep else 0
        self._sweep = fingerprint
        return "the LiDAR repeats the same points" if self._sweeps >= SAME_SWEEPS else ""

    def _picture_fault(self, frame: CameraFrame, moves: bool, camera: str) -> str:
        sample = frame.rgb[::SAMPLE_STEP, ::SAMPLE_STEP].copy()
        last, repetitions = self._pictures.get(camera, (None, 0))
        is_same = last is not None and np.array_equal(sample, last)
        repetitions = repetitions + int(moves) if is_same else 0
        self._pictures[camera] = sample, repetitions
        if sample.mean() < MIN_BRIGHTNESS or sample.std() < MIN_CONTRAST:
            return f"the {camera}'s image is black or empty"
        return f"the {camera} repeats the same image" if repetitions >= SAME_PICTURES else ""

    def _set_fault(self, sensor: str, reason: str) -> None:
        if reason:
            self._faults[sensor] = reason
        else:
            self._faults.pop(sensor, None)
