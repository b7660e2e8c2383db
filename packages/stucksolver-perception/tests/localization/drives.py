"""Simulated drives with the noise that the rig states, and the body's slip that the filter allows for."""

from __future__ import annotations

import math

import numpy as np

from stucksolver_perception.localization import EkfLocalizer
from stucksolver_perception.measurements import GnssFix, ImuSample, WheelSpeed
from stucksolver_perception.rig import load_rig

RIG = load_rig()
STEP_S = 0.05
REAR_AXLE_M = 1.45


def standing(_, speed):
    return (-speed / 0.5 if speed > 0 else 0.0), 0.0


def town(t, speed):
    """Acceleration and yaw rate: off, round some bends, a stop every 30 s."""
    stops = t % 30.0 >= 20.0
    acceleration = (-2.0 if speed > 0.0 else 0.0) if stops else (1.5 if speed < 10.0 else 0.0)
    return acceleration, 0.3 * math.sin(0.7 * t) * min(speed, 6.0) / 6.0


def drive(seed, profile, seconds, *, fix=lambda t: True, spoilt=lambda t: 0.0, gyro=0.0, slope=0.0, compass=True):
    """Yield time, truth (x, y, yaw, speed), and the localizer, at 20 Hz.

    `fix` says when there are satellites, `spoilt` how far off a fix is; `gyro` and `slope` are the offsets.
    """
    rng = np.random.default_rng(seed)
    localizer = EkfLocalizer(RIG)
    x = y = speed = slip = 0.0
    yaw = rng.uniform(-3.0, 3.0)
    for k in range(round(seconds / STEP_S)):
        t = (k + 1) * STEP_S
        acceleration, rate = profile(t, speed)
        acceleration = max(acceleration, -speed / STEP_S)
        rate = rate if speed > 0.0 or acceleration > 0.0 else 0.0
        # Slip comes and goes: a Gauss-Markov process with 3 % of the speed and half a second.
        slip = slip * math.exp(-STEP_S / 0.5) + rng.normal(0.0, math.sqrt(1.0 - math.exp(-2.0 * STEP_S / 0.5)))
        middle, mean = yaw + rate * STEP_S / 2, speed + acceleration * STEP_S / 2
        aside = REAR_AXLE_M * rate + 0.03 * mean * slip
        x += (mean * math.cos(middle) - aside * math.sin(middle)) * STEP_S
        y += (mean * math.sin(middle) + aside * math.cos(middle)) * STEP_S
        yaw, speed = yaw + rate * STEP_S, speed + acceleration * STEP_S
        felt = acceleration + slope + rng.normal(0.0, RIG.imu_acceleration_noise_mps2)
        turned = rate + gyro + rng.normal(0.0, RIG.imu_rotation_noise_rps)
        north = math.remainder(yaw + rng.normal(0.0, 0.05), math.tau) if compass else None
        localizer.imu(ImuSample(t, (felt, 0.0, 9.81), (0.0, 0.0, turned), north))
        localizer.wheel(WheelSpeed(t, speed + rng.normal(0.0, RIG.wheel_speed_noise_mps)))
        if fix(t):
            off = rng.normal(0.0, RIG.gnss_noise_m, 3)
            localizer.gnss(GnssFix(t, x + off[0] + spoilt(t), y + off[1], off[2]))
        yield t, np.array([x, y, yaw, speed]), localizer


def error(truth, estimate):
    """(4,): x, y, yaw, speed."""
    off = np.array([estimate.x_m, estimate.y_m, estimate.yaw_rad, estimate.speed_mps]) - truth
    off[2] = math.remainder(off[2], math.tau)
    return off
