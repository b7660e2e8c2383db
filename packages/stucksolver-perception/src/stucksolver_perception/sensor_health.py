"""Checks that the sensors' data are plausible. Implausible data are dropped, so they grow old and the guard sees
that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from stucksolver_perception.camera.lens_dirt import LensMonitor
from stucksolver_perception.lidar.spray import SPRAY, THICK, isolated_points
from stucksolver_perception.measurements import CameraFrame, LidarSweep, Pixels, PoseEstimate
from stucksolver_perception.rig import LidarRig

DARK = 3.0
"""An image with a lower mean brightness (0 to 255) shows nothing: at night lamps and sky give more."""
FLAT = 2.0
"""The same for an image with a smaller variation of brightness."""
SAME_PICTURES = 3
"""Number of identical consecutive images from a moving vehicle. Simulated cameras have no noise, so a standing
vehicle proves nothing.
"""
SAME_SWEEPS = 4
"""Number of consecutive sweeps with identical points: lost rays are random."""
FEW_POINTS = 0.15
"""A sweep with a smaller share of its rays comes from a failing sensor."""
SAMPLED = 16
"""Every how many pixels of an image are compared."""


@dataclass
class SensorHealth:
    """Remembers the last data; `faults` names the present faults."""

    rig: LidarRig
    tick_s: float = 0.05
    lenses: dict[str, LensMonitor] = field(default_factory=dict)
    """By camera; a lens without a monitor is taken for clean."""
    _pictures: dict[str, tuple[Pixels, int]] = field(default_factory=dict)
    """By camera: the last image's sample, and how often it was the same before."""
    _sweep: tuple[int, float] | None = None
    _sweeps: int = 0
    _turned: dict[str, str] = field(default_factory=dict)
    """What is said of sensors that are turned."""
    _wrong: dict[str, str] = field(default_factory=dict)

    @property
    def faults(self) -> tuple[str, ...]:
        """The faults, in a few words each."""
        return tuple(self._wrong.values())

    def sweep(self, sweep: LidarSweep | None) -> LidarSweep | None:
        """Return the sweep, without spray if there is any, or None if it is not plausible."""
        why = self._why_not_sweep(sweep) or self._turned.get("LiDAR", "")
        self._note("LiDAR", why)
        return None if why or sweep is None else self._cleared(sweep)

    def _cleared(self, sweep: LidarSweep) -> LidarSweep | None:
        lost = isolated_points(sweep.points)
        share = float(lost.mean())
        if share <= SPRAY:
            return sweep
        self._note("LiDAR", f"{share:.1%} of the LiDAR's points are spray" + (", too many" if share > THICK else ""))
        return None if share > THICK else replace(sweep, points=sweep.points[~lost])

    def turned(self, sensor: str, turned_rad: float | None) -> None:
        """Note how far a sensor is turned to the left, if this is known. Its data are not believed from then on.

        This holds until the drive ends. Without sweeps the vehicle brakes, and only a vehicle that moves can measure
        the angle again. A mount that has given way does not go back by itself, either: if the data were believed again
        after a while, the vehicle would drive some tens of meters by them each time, until the angle is measured anew.
        """
        if turned_rad is not None:
            angle, side = math.degrees(abs(turned_rad)), "left" if turned_rad > 0.0 else "right"
            self._turned[sensor] = f"the {sensor} seems turned by {angle:.1f} degrees to the {side}"

    def fixes(self, doubted: bool) -> None:
        """Note whether the satellite fixes contradict each other."""
        self._note("GNSS", "the GNSS fixes contradict each other" if doubted else "")

    def picture(
        self, frame: CameraFrame, moves: bool, camera: str = "camera", pose: PoseEstimate | None = None
    ) -> CameraFrame | None:
        """Return the image, with what is known of dirt on the lens, or None if it is not plausible.

        Args:
            frame: The image.
            moves: True if the vehicle moves.
            camera: Which camera took it.
            pose: The vehicle's pose then; without it, dirt is not looked for.
        """
        why = self._why_not_picture(frame, moves, camera) or self._turned.get(camera, "")
        lens = self.lenses.get(camera)
        if why or lens is None:
            self._note(camera, why)
            return None if why else frame
        checked, dirt = lens.checked(frame, pose if moves else None, camera)
        self._note(camera, dirt)
        return checked

    def _why_not_sweep(self, sweep: LidarSweep | None) -> str:
        if sweep is None:
            return "the LiDAR is silent"
        cast = self.rig.points_per_s * self.tick_s
        if len(sweep.points) < FEW_POINTS * cast:
            return f"the LiDAR gives {len(sweep.points)} points for {cast:.0f} rays"
        mark = (len(sweep.points), float(sweep.points[:, :3].sum(dtype=np.float64)))
        self._sweeps = self._sweeps + 1 if mark == self._sweep else 0
        self._sweep = mark
        return "the LiDAR gives the same points again and again" if self._sweeps >= SAME_SWEEPS else ""

    def _why_not_picture(self, frame: CameraFrame, moves: bool, camera: str) -> str:
        sample = frame.rgb[::SAMPLED, ::SAMPLED].copy()
        last, times = self._pictures.get(camera, (None, 0))
        same = last is not None and np.array_equal(sample, last)
        times = times + int(moves) if same else 0
        self._pictures[camera] = sample, times
        if sample.mean() < DARK or sample.std() < FLAT:
            return f"the {camera}'s picture is black or empty"
        return f"the {camera} gives the same picture again and again" if times >= SAME_PICTURES else ""

    def _note(self, sensor: str, why: str) -> None:
        if why:
            self._wrong[sensor] = why
        else:
            self._wrong.pop(sensor, None)
