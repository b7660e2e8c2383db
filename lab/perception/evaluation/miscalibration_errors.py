"""Measures on recordings how well a turned LiDAR or camera is detected, and that a healthy one raises no alarm.

`python -m lab.perception.evaluation.miscalibration_errors --data DIR [DIR ...]`, recordings made with `perception
collect --every 0`. Each drive is replayed healthy, and with each of the faults from its beginning.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from lab.perception.evaluation.scoring.samples import is_continuous, looks_of, true_pose
from stucksolver_perception.camera.camera_miscalibration import CameraAlignment
from stucksolver_perception.carla.sensor_faults import TURNED_RAD, SensorFault
from stucksolver_perception.carla.sensor_suite import TickMeasurements
from stucksolver_perception.free_space import footprints
from stucksolver_perception.lidar.lidar_miscalibration import LidarAlignment
from stucksolver_perception.localization import EkfLocalizer
from stucksolver_perception.measurements import CameraFrame, Floats, GnssFix, ImuSample, PoseEstimate, WheelSpeed
from stucksolver_perception.recording import Recorded, Recording, RecordingError, recordings
from stucksolver_perception.vehicle_frame import into_vehicle

HEALTHY = "none"
CASES = (HEALTHY, "lidar-turned", "camera-turned")
MOVES_MPS = 0.3
"""Speed above which an object counts as moving (m/s). Ours; the truth replaces the tracker here."""


@dataclass
class Errors:
    """Measurements with one fault, over all drives."""

    drives: int = 0
    """Number of drives."""
    lidar_deg: list[float] = field(default_factory=list)
    """Errors of single measurements of the LiDAR's angle (degrees)."""
    camera_deg: list[float] = field(default_factory=list)
    lidar_noticed_m: list[float] = field(default_factory=list)
    """Distances driven until the alarm for the LiDAR (m), for each drive with one."""
    camera_noticed_m: list[float] = field(default_factory=list)


def played(recording: Recording, case: str, errors: Errors) -> None:
    """Replay a drive with a fault and add the measurements to the errors."""
    fault = None if case == HEALTHY else SensorFault(case, camera=recording.rig.camera)
    lidar, camera = LidarAlignment(recording.rig.lidar), CameraAlignment(recording.rig)
    # Both faults turn the measurements to the left: the sensor is turned to the right.
    turned = {name: -math.degrees(TURNED_RAD) * (case == name) for name in CASES}
    accused_lidar = accused_camera = False
    driven_m, localizer = 0.0, EkfLocalizer(recording.rig)
    for ticks in looks_of(recording):
        looks = [(_measured(tick, fault), _localized(localizer, tick)) for tick in ticks]
        driven_m += sum(abs(pose.speed_mps) for _, pose in looks) * _tick_s(ticks)
        sweeps = [(now.sweep, pose) for now, pose in looks if now.sweep is not None]
        for sweep, pose in sweeps:
            lidar.add(sweep, pose)
        for now, pose in looks:
            if now.picture is not None:
                camera.look(now.picture, pose, sweeps)
        match = lidar.look(_moving(ticks[-1]))
        if match is not None:
            errors.lidar_deg.append(math.degrees(match.turned_rad) - turned["lidar-turned"])
            angle = camera.measure(match.turned_rad)
            errors.camera_deg += [] if angle is None else [math.degrees(angle) - turned["camera-turned"]]
        if lidar.turned_rad is not None and not accused_lidar:
            accused_lidar = True
            errors.lidar_noticed_m.append(driven_m)
        if camera.turned_rad is not None and not accused_camera:
            accused_camera = True
            errors.camera_noticed_m.append(driven_m)
    errors.drives += 1


def as_table(found: dict[str, Errors]) -> str:
    """Return a Markdown table."""
    lines = [
        "| | drives | error: median, 95 %, 99 % (degrees) | accused | after: median, latest (m) |",
        "|---|---|---|---|---|",
    ]
    for case, errors in found.items():
        for sensor, degrees, after in (
            ("LiDAR", errors.lidar_deg, errors.lidar_noticed_m),
            ("camera", errors.camera_deg, errors.camera_noticed_m),
        ):
            spread = (
                ", ".join(f"{item:.2f}" for item in np.percentile(np.abs(degrees), [50, 95, 99])) if degrees else "-"
            )
            meters = ", ".join(f"{item:.0f}" for item in np.percentile(after, [50, 100])) if after else "-"
            lines.append(f"| {case}: {sensor} | {errors.drives} | {spread} | {len(after)} | {meters} |")
    return "\n".join(lines)


def _measured(tick: Recorded, fault: SensorFault | None) -> TickMeasurements:
    picture = tick.picture()
    frame = None if picture is None else CameraFrame(tick.time_s, picture)
    now = TickMeasurements(tick.sweep, frame, None, None, WheelSpeed(tick.time_s, tick.wheel_mps))
    return now if fault is None else fault.after(now, tick.time_s)


def _localized(localizer: EkfLocalizer, tick: Recorded) -> PoseEstimate:
    a, w = tick.imu[:3].tolist(), tick.imu[3:6].tolist()
    localizer.imu(ImuSample(tick.time_s, (a[0], a[1], a[2]), (w[0], w[1], w[2]), float(tick.imu[6])))
    localizer.wheel(WheelSpeed(tick.time_s, tick.wheel_mps))
    localizer.gnss(GnssFix(tick.time_s, *tick.gnss.tolist()))
    return localizer.estimate(tick.time_s)


def _moving(tick: Recorded) -> Floats:
    boxes = tick.truth.boxes
    moving = boxes[np.hypot(boxes[:, 7], boxes[:, 8]) > MOVES_MPS]
    return footprints(into_vehicle(moving[:, [0, 1, 2, 4, 5, 6, 3]], true_pose(tick)))


def _tick_s(ticks: Sequence[Recorded]) -> float:
    return 0.05 if len(ticks) < 2 else ticks[-1].time_s - ticks[-2].time_s


def _whole(folders: Sequence[Path]) -> Iterator[Recording]:
    for folder in folders:
        yield from (recording for recording in recordings(folder) if is_continuous(recording))


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print the table; return 2 if there is no recording to measure on, else 0."""
    parser = argparse.ArgumentParser(description="Measures how well turned sensors are noticed.")
    parser.add_argument("--data", type=Path, nargs="+", required=True, help="recordings without gaps (--every 0)")
    args = parser.parse_args(arguments)
    found = {case: Errors() for case in CASES}
    try:
        for recording in _whole(args.data):
            for case, errors in found.items():
                played(recording, case, errors)
    except RecordingError as error:
        # The error is printed as one line, without a traceback.
        print(f"alignment_errors: {error}", file=sys.stderr)
        return 2
    if not found[HEALTHY].drives:
        print("alignment_errors: all recordings have gaps. Collect some with --every 0", file=sys.stderr)
        return 2
    print(as_table(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
