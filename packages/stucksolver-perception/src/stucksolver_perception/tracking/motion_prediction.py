"""How objects move between two looks: constant velocity with white noise of acceleration and turn rate.

The filter's prediction and the one for later moments (`Track.at`) use the same formulas.
"""

from __future__ import annotations

import math

import numpy as np

from stucksolver_perception.measurements import Floats
from stucksolver_perception.tracking.motion_groups import MotionGroup

STATE = 6
"""x, y, z, yaw, vx, vy."""
STANDING_ACCELERATION_MPS2 = 0.02
"""Velocity noise of a standing object: its covariance grows while it is hidden, to 2 m in 30 s. A thing does not set
off unseen: for it only the ego's own pose drifts.
"""
STANDING_TURN_RPS = 0.02
STANDING_DRIFT_MPS = 0.05
"""Drift of the ego's own pose, and with it of everything that stands (m per root of a second), ..."""
HELD_DRIFT_MPS = 0.01
"""... and while the ego stands, since the localizer holds its pose."""


def transition(
    group: MotionGroup, stands: bool, dt: float, yaw_rad: float, held: bool = False
) -> tuple[Floats, Floats]:
    """Transition matrix and process noise, (6, 6) each, for a step of `dt` seconds. `held`: the ego stands as well.

    The noise is that of a continuous white-noise acceleration (Bar-Shalom, Li and Kirubarajan 2001, 6.2.2).
    """
    rests = stands and group.lifeless
    along, across = (STANDING_ACCELERATION_MPS2,) * 2 if stands else (group.acceleration_mps2, group.across_mps2)
    drift = HELD_DRIFT_MPS if rests and held else STANDING_DRIFT_MPS
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    turned = np.array([[cos, -sin], [sin, cos]])
    power = turned @ np.diag([along**2, across**2]) @ turned.T
    turn = STANDING_TURN_RPS if stands else group.turn_rps
    span = abs(dt)
    f = np.eye(STATE)
    q = np.zeros((STATE, STATE))
    q[:2, :2] = drift**2 * span * np.eye(2)
    if not rests:
        f[:2, 4:] = dt * np.eye(2)
        q[:2, :2] += power * span**3 / 3.0
        q[:2, 4:] = q[4:, :2] = power * span**2 / 2.0
    q[4:, 4:] = power * span
    q[2, 2] = drift**2 * span
    q[3, 3] = turn**2 * span
    return f, q
