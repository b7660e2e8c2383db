"""Defines the motion model of the vehicle's state."""

from __future__ import annotations

import math

import numpy as np

from stucksolver_perception.measurements import Floats

STATE = 6
"""Number of values of the state: x, y (m), yaw (rad), speed (m/s), offset of the gyro (rad/s), offset of the
accelerometer (m/s²)."""
X = 0
"""Index of x."""
Y = 1
"""Index of y."""
YAW = 2
"""Index of the yaw."""
SPEED = 3
"""Index of the speed."""
GYRO = 4
"""Index of the gyro's offset."""
ACCELERATION = 5
"""Index of the accelerometer's offset."""
GYRO_WALK = 1e-4
"""Drift of the gyro's offset (rad/s per root of a second). Ours."""
ACCELERATION_WALK = 0.2
"""Drift of the accelerometer's offset (m/s² per root of a second), mostly from gravity on changing slopes. Ours."""
SLIP = 0.03
"""Standard deviation of the lateral velocity that the model lacks, as a share of the speed, because the body slides.
Ours."""
SLIP_S = 0.5
"""Time constant of this velocity (s). Ours."""
WHEEL_SHARE = 0.003
"""Standard deviation of the wheels' speed error, as a share of the speed, because tires wear and slip. Ours."""
WHEEL_S = 5.0
"""Time constant of this error (s). Ours."""
FIXED_MPS = 0.005
"""Position noise of a stopped vehicle (m per root of a second), so that the filter still uses new data. Ours."""


def predict_state(
    state: Floats, acceleration_mps2: float, rotation_rps: float, rear_axle_m: float, dt: float
) -> tuple[Floats, Floats]:
    """Return the state `dt` seconds later, and its derivative by the state (6, 6).

    This is a bicycle model. The rear axle, `rear_axle_m` behind the reference point, moves only along the heading, so
    that the reference point has a lateral velocity in turns (Rajamani, "Vehicle Dynamics and Control", chapter 2).
    """
    yaw, speed = float(state[YAW]), float(state[SPEED])
    rate = rotation_rps - float(state[GYRO])
    acceleration = acceleration_mps2 - float(state[ACCELERATION])
    mid_yaw, mean_speed = yaw + rate * dt / 2.0, speed + acceleration * dt / 2.0
    lateral_mps = rear_axle_m * rate
    cos, sin = math.cos(mid_yaw), math.sin(mid_yaw)
    after = state.copy()
    after[X] += (mean_speed * cos - lateral_mps * sin) * dt
    after[Y] += (mean_speed * sin + lateral_mps * cos) * dt
    after[YAW] += rate * dt
    after[SPEED] += acceleration * dt
    f = np.eye(STATE)
    d_x_d_yaw, d_y_d_yaw = (-mean_speed * sin - lateral_mps * cos) * dt, (mean_speed * cos - lateral_mps * sin) * dt
    f[X, YAW], f[Y, YAW] = d_x_d_yaw, d_y_d_yaw
    f[X, SPEED], f[Y, SPEED] = cos * dt, sin * dt
    f[X, GYRO] = rear_axle_m * sin * dt - d_x_d_yaw * dt / 2.0
    f[Y, GYRO] = -rear_axle_m * cos * dt - d_y_d_yaw * dt / 2.0
    f[X, ACCELERATION], f[Y, ACCELERATION] = -cos * dt**2 / 2.0, -sin * dt**2 / 2.0
    f[YAW, GYRO] = -dt
    f[SPEED, ACCELERATION] = -dt
    return after, f


def process_noise(state: Floats, acceleration_noise: float, rotation_noise: float, dt: float) -> Floats:
    """Return (6, 6): the process noise of a step. The noises are standard deviations of one sample of each sensor."""
    span = abs(dt)
    ahead = np.array([math.cos(state[YAW]), math.sin(state[YAW])])
    side = np.array([-ahead[1], ahead[0]])
    q = np.zeros((STATE, STATE))
    # A correlated error adds up like white noise with twice its time constant (Gauss-Markov process).
    lateral = (SLIP * state[SPEED]) ** 2 * 2.0 * SLIP_S
    along = (WHEEL_SHARE * state[SPEED]) ** 2 * 2.0 * WHEEL_S
    q[:2, :2] = (lateral * np.outer(side, side) + along * np.outer(ahead, ahead) + FIXED_MPS**2 * np.eye(2)) * span
    q[YAW, YAW] = (rotation_noise * span) ** 2
    q[SPEED, SPEED] = (acceleration_noise * span) ** 2
    q[GYRO, GYRO] = GYRO_WALK**2 * span
    q[ACCELERATION, ACCELERATION] = ACCELERATION_WALK**2 * span
    return q
