"""Records one drive: the sensor data of the ego's rig and the ground truth, in windows of ticks."""

from __future__ import annotations

import shutil

import numpy as np

from lab.perception.recording.ground_truth import LightsReader, TruthReader, ego_pose, in_snapshot
from lab.perception.recording.recording_sensors import RecordingSensors
from stucksolver_eval.runner.recording_spec import RecordingSpec
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_perception.carla.sensor_conversion import wheel_speed_mps
from stucksolver_perception.measurements import LidarSweep
from stucksolver_perception.recording import Recorded, RecordingWriter
from stucksolver_perception.rig import load_rig

SETTLE_S = 2.0
"""Time after which spawned actors have settled and the first images have arrived (s). Ours."""
PICTURE_S = 0.5
"""Time between two images if all ticks are stored (s). Ours."""


class DriveRecorder:
    """Create it after all actors are spawned, call `tick` after every tick, and `close` at the end.

    Raises:
        SensorError: In the constructor and `tick`: a sensor cannot be mounted or sends no data.
    """

    def __init__(self, spec: RecordingSpec, setting: ScenarioContext, seed: int, about: dict[str, object]) -> None:
        shutil.rmtree(spec.folder, ignore_errors=True)
        self._spec, self._setting = spec, setting
        self._rig = load_rig(spec.rig_file)
        self._period_s = spec.every_s or PICTURE_S
        self._random = np.random.default_rng(seed)
        cast = setting.cast
        self._truth = TruthReader(setting.world, setting.hero.id, lambda actor: cast.doors_open.get(actor, 0))
        self._lights = LightsReader(setting.world)
        self._sensors = RecordingSensors(setting.hero, self._rig, setting.map, self._period_s, seed)
        self._first_picture: int | None = None
        self._writer = RecordingWriter(spec.folder, self._rig, {"town": setting.map.name.split("/")[-1], **about})
        self._start_s = float(setting.world.get_snapshot().timestamp.elapsed_seconds)

    def tick(self) -> None:
        """Record the current tick if it belongs to a window.

        Raises:
            SensorError: A sensor sends no data.
        """
        snapshot = self._setting.world.get_snapshot()
        frame, time_s = int(snapshot.frame), float(snapshot.timestamp.elapsed_seconds) - self._start_s
        if self._first_picture is None:
            self._first_picture = self._sensors.first_picture()
        if time_s < SETTLE_S or self._first_picture is None:
            return
        to_picture = (self._first_picture - frame) % round(self._period_s / self._setting.dt_s)
        if self._spec.every_s > 0.0 and to_picture >= self._spec.window_ticks:
            return
        pose = ego_pose(in_snapshot(snapshot, self._setting.hero.id))
        speed_mps, has_picture = float(pose[6]), to_picture == 0
        self._writer.add(
            Recorded(
                time_s=time_s,
                pose=pose,
                sweep=LidarSweep(time_s, self._sensors.points(frame)),
                imu=self._sensors.imu(frame),
                gnss=self._sensors.gnss(frame),
                wheel_mps=wheel_speed_mps(speed_mps, self._rig.wheel_speed_noise_mps, self._random),
                truth=self._truth.read(snapshot),
                lights=self._lights.read(float(pose[0]), float(pose[1])) if has_picture else None,
                jpeg=self._sensors.jpeg(frame) if has_picture else None,
                instances=self._sensors.instances(frame) if has_picture else None,
            )
        )

    def close(self) -> None:
        """Destroy the sensors and write the remaining data."""
        self._sensors.close()
        self._writer.close()
