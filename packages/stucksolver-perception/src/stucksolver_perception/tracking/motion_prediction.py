"""Predicts objects with constant velocity, and white noise of acceleration and turn rate.

The filter and the prediction of tracks to later times (`Track.predict_to`) use the same formulas.
"""

from __future__ import annotations

import math

import numpy as np

from stucksolver_perception.measurements import Floats
from stucksolver_perception.tracking.motion_groups import MotionGroup

STATE = 6
"""Number of values of the state: x, y, z, yaw, vx, vy."""
STATIONARY_ACCELERATION_MPS2 = 0.02
"""Standard deviation of a stationary object's acceleration (m/s²). While the object is hidden, its position's standard
deviation grows to 2 m in 30 s. For a static object, only the ego's pose drifts. Ours."""
STATIONARY_TURN_RPS = 0.02
"""Standard deviation of a stationary object's turn rate (rad/s). Ours."""
STATIONARY_DRIFT_MPS = 0.05
"""Drift of the ego's pose, and so of all objects (m per root of a second). Ours."""
STOPPED_DRIFT_MPS = 0.01
"""Drift while the ego is stopped, when the localizer holds its pose (m per root of a second). Ours."""


def transition(
    group: MotionGroup, is_stationary: bool, dt: float, yaw_rad: float, ego_is_stopped: bool = False
) -> tuple[Floats, Floats]:
    """Return transition matrix and process noise, (6, 6) each, of a step of `dt` seconds.

    The noise is that of a continuous white-noise acceleration (Bar-Shalom, Li and Kirubarajan 2001, 6.2.2).
    """
    is_fixed = is_stationary and group.is_static
    along, across = (
        (STATIONARY_ACCELERATION_MPS2,) * 2 if is_stationary else (group.acceleration_mps2, group.across_mps2)
    )
    drift = STOPPED_DRIFT_MPS if is_fixed and ego_is_stopped else STATIONARY_DRIFT_MPS
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    turned = np.array([[cos, -sin], [sin, cos]])
    power = turned @ np.diag([along**2, across**2]) @ turned.T
    turn = STATIONARY_TURN_RPS if is_stationary else group.turn_rps
    span = abs(dt)
    f = np.eye(STATE)
    q = np.zeros((STATE, STATE))
    q[:2, :2] = drift**2 * span * np.eye(2)
    if not is_fixed:
        f[:2, 4:] = dt * np.eye(2)
        q[:2, :2] += power * span**3 / 3.0
        q[:2, 4:] = q[4:, :2] = power * span**2 / 2.0
    q[4:, 4:] = power * span
    q[2, 2] = drift**2 * span
    q[3, 3] = turn**2 * span
    return f, q
