"""The inertial measurement unit: accelerometer, gyroscope and compass, all in the sensor's own frame."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import msgpack
import numpy as np

from carlette.geometry import Floats
from carlette.physics.vehicle_dynamics import GRAVITY
from carlette.sensors.gnss import seeded
from carlette.sensors.rotations import axes, turn_between
from carlette.sensors.sensor import Body, Sensor, SensorAttributes, SensorTick

_AXES = ("x", "y", "z")
SHORTEST_STEP_S = 1e-6
"""Shortest time between two measurements in a quotient (s), against a division by zero."""
_SUPPORT = np.array([0.0, 0.0, GRAVITY])
"""Acceleration that supports the sensor against gravity (m/s²)."""


@dataclass(frozen=True)
class Attitude:
    """Position and attitude of the sensor at one measurement, world frame."""

    time_s: float
    place: Floats
    axes: Floats


class ImuSensor(Sensor):
    """Measures from the sensor's own path, so that its position on the vehicle matters.

    Acceleration is the second difference of the last three positions, as in CARLA, plus the support against
    gravity. The turn rate is the change of attitude since the last measurement. Both are zero until enough
    measurements are available.
    """

    wire_type = 5

    def __init__(self, settings: SensorAttributes) -> None:
        super().__init__(settings)
        self._accelerometer_stddev = np.array([settings.number(f"noise_accel_stddev_{axis}", 0.0) for axis in _AXES])
        self._gyroscope_stddev = np.array([settings.number(f"noise_gyro_stddev_{axis}", 0.0) for axis in _AXES])
        self._gyroscope_bias = np.array([settings.number(f"noise_gyro_bias_{axis}") for axis in _AXES])
        self._random = seeded(settings)
        self._path: deque[Attitude] = deque(maxlen=3)

    def measure(self, moment: SensorTick) -> Iterator[Body]:
        self.pass_over(moment)
        noise = self._random.normal(0.0, 1.0, (2, 3))
        here = self._path[-1].axes
        felt = here.T @ (self._acceleration() + _SUPPORT) + noise[0] * self._accelerometer_stddev
        turning = here.T @ self._turning() + self._gyroscope_bias + noise[1] * self._gyroscope_stddev
        yield (msgpack.packb([felt.tolist(), turning.tolist(), compass(here)]),)

    def pass_over(self, moment: SensorTick) -> None:
        time_s = moment.scene.world.elapsed_s
        self._path.append(Attitude(time_s, np.array(moment.pose.location), axes(moment.pose.rotation)))

    def _acceleration(self) -> Floats:
        """Return the acceleration (m/s², world frame)."""
        if len(self._path) < 3:
            return np.zeros(3)
        first, middle, last = self._path
        before = max(middle.time_s - first.time_s, SHORTEST_STEP_S)
        after = max(last.time_s - middle.time_s, SHORTEST_STEP_S)
        change = (last.place - middle.place) / after - (middle.place - first.place) / before
        acceleration: Floats = change / (0.5 * (before + after))
        return acceleration

    def _turning(self) -> Floats:
        """Return the turn rate (rad/s, world frame)."""
        if len(self._path) < 2:
            return np.zeros(3)
        before, now = self._path[-2], self._path[-1]
        return turn_between(before.axes, now.axes) / max(now.time_s - before.time_s, SHORTEST_STEP_S)


def compass(frame: Floats) -> float:
    """Return the heading from north (CARLA's -y) over east (+x), 0 to 2π (rad)."""
    ahead = frame[:, 0]
    return math.atan2(ahead[0], -ahead[1]) % math.tau
