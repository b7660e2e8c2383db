"""The motion model of the vehicle's state, and the expected reading of each sensor."""

from __future__ import annotations

import math

import numpy as np

from stucksolver_perception.measurements import Floats

STATE = 6
"""x, y (m), yaw (rad), speed (m/s), offset of the gyro (rad/s), offset of the accelerometer (m/s²)."""
X = 0
Y = 1
YAW = 2
SPEED = 3
GYRO = 4
ACCELERATION = 5
GYRO_WALK = 1e-4
"""How the gyro's offset drifts (rad/s per root of a second)."""
ACCELERATION_WALK = 0.2
"""How the accelerometer's offset drifts (m/s² per root of a second): mostly gravity, as slopes come and go."""
SLIP = 0.03
"""Standard deviation of the lateral velocity that the model misses, as a share of the speed: the body slides."""
SLIP_S = 0.5
"""Time for which it keeps its sign."""
WHEEL_SHARE = 0.003
"""The same along the heading: tires wear and slip, so the wheels' distance is wrong by this share,"""
WHEEL_S = 5.0
"""for about this time."""
FIXED_MPS = 0.005
"""Position noise of a standing vehicle (m per root of a second), so that the filter stays open to new data."""


def predicted_state(
    state: Floats, acceleration_mps2: float, rotation_rps: float, rear_axle_m: float, dt: float
) -> tuple[Floats, Floats]:
    """Return the state `dt` seconds later, and its derivative by the state (6, 6).

    A bicycle model: the rear axle, `rear_axle_m` behind the reference point, moves along the heading only, so that the
    reference point moves sideways with the yaw rate (Rajamani, "Vehicle Dynamics and Control", chapter 2).
    """
    yaw, speed = float(state[YAW]), float(state[SPEED])
    rate = rotation_rps - float(state[GYRO])
    gained = acceleration_mps2 - float(state[ACCELERATION])
    middle, mean = yaw + rate * dt / 2.0, speed + gained * dt / 2.0
    aside = rear_axle_m * rate
    cos, sin = math.cos(middle), math.sin(middle)
    after = state.copy()
    after[X] += (mean * cos - aside * sin) * dt
    after[Y] += (mean * sin + aside * cos) * dt
    after[YAW] += rate * dt
    after[SPEED] += gained * dt
    f = np.eye(STATE)
    by_yaw_x, by_yaw_y = (-mean * sin - aside * cos) * dt, (mean * cos - aside * sin) * dt
    f[X, YAW], f[Y, YAW] = by_yaw_x, by_yaw_y
    f[X, SPEED], f[Y, SPEED] = cos * dt, sin * dt
    f[X, GYRO] = rear_axle_m * sin * dt - by_yaw_x * dt / 2.0
    f[Y, GYRO] = -rear_axle_m * cos * dt - by_yaw_y * dt / 2.0
    f[X, ACCELERATION], f[Y, ACCELERATION] = -cos * dt**2 / 2.0, -sin * dt**2 / 2.0
    f[YAW, GYRO] = -dt
    f[SPEED, ACCELERATION] = -dt
    return after, f


def disturbance(state: Floats, acceleration_noise: float, rotation_noise: float, dt: float) -> Floats:
    """(6, 6): process noise of a step. The noises are standard deviations of one sample of each sensor."""
    span = abs(dt)
    ahead = np.array([math.cos(state[YAW]), math.sin(state[YAW])])
    side = np.array([-ahead[1], ahead[0]])
    q = np.zeros((STATE, STATE))
    # An error that lasts for a while adds up like white noise of twice that time constant (Gauss-Markov process).
    aside = (SLIP * state[SPEED]) ** 2 * 2.0 * SLIP_S
    along = (WHEEL_SHARE * state[SPEED]) ** 2 * 2.0 * WHEEL_S
    q[:2, :2] = (aside * np.outer(side, side) + along * np.outer(ahead, ahead) + FIXED_MPS**2 * np.eye(2)) * span
    q[YAW, YAW] = (rotation_noise * span) ** 2
    q[SPEED, SPEED] = (acceleration_noise * span) ** 2
    q[GYRO, GYRO] = GYRO_WALK**2 * span
    q[ACCELERATION, ACCELERATION] = ACCELERATION_WALK**2 * span
    return q
