"""Ackermann control: a wheel angle, a speed and an acceleration instead of pedals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from carlette.physics.bodies import Bodies
from carlette.physics.fleet import BRAKE_MPS2, Fleet

SPEED_GAIN_PER_S = 2.0
DEFAULT_ACCELERATION_MPS2 = 3.0


def ackermann_control(fleet: Fleet, bodies: Bodies, index: int, wanted: Sequence[float]) -> tuple[float, ...]:
    """The vehicle control for `[steer (rad), steer speed, speed (m/s), acceleration (m/s²), jerk]`.

    It inverts the vehicle's model once, when the command arrives; clients send a new one in each tick.
    """
    angle, _, speed, acceleration, _ = wanted
    row = fleet.row[index]
    yaw = np.radians(bodies.rotation[row, 1])
    ahead = float(bodies.velocity[row, 0] * np.cos(yaw) + bodies.velocity[row, 1] * np.sin(yaw))
    steer = float(np.clip(angle / fleet.max_steer[index], -1.0, 1.0))
    bound = abs(acceleration) or DEFAULT_ACCELERATION_MPS2
    change = float(np.clip(SPEED_GAIN_PER_S * (speed - ahead), -bound, bound))
    reverse = speed < 0 and ahead < 0.5
    change = -change if reverse else change
    throttle = float(np.clip(change / fleet.launch[index], 0.0, 1.0))
    brake = float(np.clip(-change / BRAKE_MPS2, 0.0, 1.0)) if speed else float(abs(ahead) < 0.5 or -change / BRAKE_MPS2)
    return (throttle, steer, min(max(brake, 0.0), 1.0), 0.0, float(reverse), 0.0, 1.0)
