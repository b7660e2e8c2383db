"""An extended Kalman filter over satellites, inertial sensors, compass and wheels."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import numpy as np

from stucksolver_perception.localization.vehicle_state_model import (
    ACCELERATION,
    GYRO,
    SPEED,
    STATE,
    YAW,
    X,
    disturbance,
    predicted_state,
)
from stucksolver_perception.measurements import Floats, GnssFix, ImuSample, PoseEstimate, WheelSpeed
from stucksolver_perception.rig import Rig

REAR_AXLE_M = 1.45
"""Distance of the rear axle behind the reference point: half of a usual wheelbase of 2.9 m."""
COMPASS_RAD = 0.05
"""Standard deviation of the compass; its errors last, so that it is read only"""
COMPASS_EVERY_S = 1.0
GYRO_OFFSET_RPS = 0.01
"""Standard deviation of the gyro's offset before anything is known of it."""
ACCELERATION_OFFSET_MPS2 = 0.5
"""The same of the accelerometer's, slopes included."""
GATE_2 = 18.42
"""Chi-square with 2 degrees of freedom: one good fix in ten thousand is refused."""
GATE_1 = 15.14
"""The same with 1 degree of freedom."""
REFUSED_IN_A_ROW = 20
"""After this many consecutive refused fixes the filter is wrong, not the fixes: it widens its covariance."""
RECENT_FIXES = 20
"""Fixes are compared with each other over this many, one second."""
SCATTER, AGREE = 2.5, 1.6
"""If they scatter by more than the first many times their stated noise, they are wrong, not the filter. None is used
until they scatter by less than the second. The vehicle then goes on by its wheels and gyro, which are off by a meter
after some hundred. A wrong filter sees fixes that are all off by the same.
"""
STANDING_LOOKS = 10
"""Number of wheel speeds that decide that the vehicle stands,"""
STANDING_SIGMAS = 3.0
"""if their mean is within this many standard deviations of zero."""
STEADY_MPS2 = 0.1
"""A vehicle that pulls away is felt before its wheels show it: the acceleration may change by no more than this."""
STANDSTILL_MPS = 0.005
"""Standard deviation of the speed of a standing vehicle."""
HEIGHT_GAIN_S = 5.0
"""Averaging time of heights."""
STALE_S = 0.1
"""Data older than the state by more than this are not used."""


class NotLocalizedError(RuntimeError):
    """There is no pose yet. The message says which sensor is missing."""


class EkfLocalizer:
    """Takes every sample in order of time; call `estimate` at any time.

    The inertial sensors predict the state, with one offset of the gyro and one of the accelerometer (on slopes it holds
    gravity's share). Wheels, fixes and, once a second, the compass correct it. While the wheels stand, the speed is
    held at zero and the gyro's offset is measured (zero-velocity update).
    """

    def __init__(self, rig: Rig, start: PoseEstimate | None = None, rear_axle_m: float = REAR_AXLE_M) -> None:
        """Begin at `start`, or with the first fix and the first compass reading."""
        self._rig = rig
        self._rear_axle_m = rear_axle_m
        self._filter: Any = None
        self._time_s = 0.0
        self._z_m = 0.0
        self._height_s = 0.0
        self._inertial = (0.0, 0.0)
        """The last measured acceleration along the heading and yaw rate."""
        self._doubt = (0.0, 0.0)
        """Their largest difference from the mean over the last step."""
        self._yaw_rad: float | None = None
        self._fix: GnssFix | None = None
        self._compass_s = -math.inf
        self._wheels: deque[float] = deque(maxlen=STANDING_LOOKS)
        self._felt: deque[float] = deque(maxlen=STANDING_LOOKS)
        self._refused_in_a_row = 0
        self._offs: deque[Floats] = deque(maxlen=RECENT_FIXES)
        """How far the last fixes were from the predicted positions."""
        self.doubts_fixes = False
        """True if the fixes contradict each other, so that none is used."""
        self.refused_fixes = 0
        """Number of fixes too far from the vehicle's possible positions."""
        if start is not None:
            self._begin(start)

    @property
    def ready(self) -> bool:
        """True if there is a pose."""
        return self._filter is not None

    @property
    def stands(self) -> bool:
        """True if the wheels say that the vehicle stands and no change of its acceleration is felt."""
        if len(self._wheels) < STANDING_LOOKS or not self._felt:
            return False
        limit = STANDING_SIGMAS * self._rig.wheel_speed_noise_mps / math.sqrt(STANDING_LOOKS)
        steady = max(STEADY_MPS2, 6.0 * self._rig.imu_acceleration_noise_mps2)
        rolls = abs(sum(self._wheels) / STANDING_LOOKS) > limit
        return not rolls and max(self._felt) - min(self._felt) < steady

    def imu(self, sample: ImuSample) -> None:
        """Predict to the sample's time with its acceleration and yaw rate."""
        before = self._inertial
        self._inertial = (sample.acceleration_mps2[0], sample.rotation_rps[2])
        self._felt.append(sample.acceleration_mps2[0])
        if sample.compass_rad is not None and self._yaw_rad is None:
            self._yaw_rad = sample.compass_rad
        if not self.ready:
            self._begin_by_sensors()
            return
        # A sample is the mean over the step that ends with it, as inertial sensors integrate. Half of its difference
        # from the one before may be wrong: a simulator may report the step's last moment instead.
        self._doubt = (abs(self._inertial[0] - before[0]) / 2.0, abs(self._inertial[1] - before[1]) / 2.0)
        self._advance(sample.time_s, self._inertial)
        if self.stands:
            self._standstill(sample)
        if sample.compass_rad is not None and sample.time_s - self._compass_s >= COMPASS_EVERY_S - 1e-6:
            self._compass_s = sample.time_s
            self._correct(YAW, sample.compass_rad, COMPASS_RAD, angle=True)

    def wheel(self, speed: WheelSpeed) -> None:
        """Correct the speed by the wheels."""
        self._wheels.append(speed.speed_mps)
        if self.ready and self._current(speed.time_s):
            self._correct(SPEED, speed.speed_mps, self._rig.wheel_speed_noise_mps)

    def gnss(self, fix: GnssFix) -> None:
        """Correct the position by a fix, unless the vehicle cannot be there."""
        if not self.ready:
            self._fix = fix
            self._begin_by_sensors()
            return
        if not self._current(fix.time_s):
            return
        ekf, h = self._filter, np.eye(STATE)[:2]
        r = np.eye(2) * self._rig.gnss_noise_m**2
        z = np.array([fix.x_m, fix.y_m])
        off = z - ekf.x[:2]
        self._compare(off)
        if self.doubts_fixes:
            self.refused_fixes += 1
            self._refused_in_a_row = 0
            return
        if float(off @ np.linalg.solve(ekf.P[:2, :2] + r, off)) > GATE_2:
            self._refuse()
            return
        self._refused_in_a_row = 0
        ekf.update(z, lambda _: h, lambda x: x[:2], R=r)
        self._z_m += (fix.z_m - self._z_m) * min(1.0, max(0.0, fix.time_s - self._height_s) / HEIGHT_GAIN_S)
        self._height_s = fix.time_s

    def estimate(self, time_s: float) -> PoseEstimate:
        """Return the pose at a time (s), predicted from the last sample; the filter does not change.

        Raises:
            NotLocalizedError: There was no fix or no compass reading yet.
        """
        if not self.ready:
            missing = "a fix" if self._fix is None else "a compass reading"
            raise NotLocalizedError(f"there is no pose yet: waiting for {missing}; or give a start")
        ekf, (acceleration, rotation) = self._filter, self._inertial
        x, p, dt = ekf.x, ekf.P, time_s - self._time_s
        if abs(dt) > 1e-6:
            x, f = predicted_state(ekf.x, acceleration, rotation, self._rear_axle_m, dt)
            p = f @ p @ f.T + self._noise(dt)
        yaw = math.remainder(float(x[YAW]), math.tau)
        rate = rotation - float(x[GYRO])
        return PoseEstimate(time_s, float(x[X]), float(x[1]), self._z_m, yaw, float(x[SPEED]), rate, p[:4, :4].copy())

    def _begin_by_sensors(self) -> None:
        if self._fix is None or self._yaw_rad is None:
            return
        fix, noise = self._fix, self._rig.gnss_noise_m**2
        speed = self._wheels[-1] if self._wheels else 0.0
        # Without wheel data the speed is unknown.
        spread = self._rig.wheel_speed_noise_mps**2 if self._wheels else 10.0**2
        covariance = np.diag([noise, noise, COMPASS_RAD**2, spread])
        self._begin(PoseEstimate(fix.time_s, fix.x_m, fix.y_m, fix.z_m, self._yaw_rad, speed, 0.0, covariance))
        self._compass_s = fix.time_s

    def _begin(self, start: PoseEstimate) -> None:
        from filterpy.kalman import ExtendedKalmanFilter  # type: ignore[import-untyped]

        ekf = ExtendedKalmanFilter(dim_x=STATE, dim_z=2)
        ekf.x = np.array([start.x_m, start.y_m, start.yaw_rad, start.speed_mps, 0.0, 0.0])
        ekf.P = np.diag([0.0] * 4 + [GYRO_OFFSET_RPS**2, ACCELERATION_OFFSET_MPS2**2])
        ekf.P[:4, :4] = start.covariance
        self._filter, self._time_s = ekf, start.time_s
        self._z_m, self._height_s = start.z_m, start.time_s

    def _advance(self, time_s: float, inertial: tuple[float, ...]) -> None:
        dt = time_s - self._time_s
        if dt <= 0.0:
            return
        ekf = self._filter
        after, ekf.F = predicted_state(ekf.x, inertial[0], inertial[1], self._rear_axle_m, dt)
        ekf.Q = self._noise(dt)
        ekf.predict()
        # filterpy's step is linear; the covariance is right, and the state is the model's.
        ekf.x = after
        self._time_s = time_s

    def _noise(self, dt: float) -> Floats:
        acceleration = math.hypot(self._rig.imu_acceleration_noise_mps2, self._doubt[0])
        rotation = math.hypot(self._rig.imu_rotation_noise_rps, self._doubt[1])
        return disturbance(self._filter.x, acceleration, rotation, dt)

    def _standstill(self, sample: ImuSample) -> None:
        """A standing vehicle has no speed, and its gyro and accelerometer read their offsets."""
        self._correct(SPEED, 0.0, STANDSTILL_MPS)
        self._correct(GYRO, sample.rotation_rps[2], self._rig.imu_rotation_noise_rps)
        self._correct(ACCELERATION, sample.acceleration_mps2[0], 0.05)

    def _current(self, time_s: float) -> bool:
        """Predict the state to a measurement's time; False if the measurement is too old."""
        self._advance(time_s, self._inertial)
        return time_s >= self._time_s - STALE_S

    def _correct(self, what: int, value: float, sigma: float, angle: bool = False) -> None:
        """Correct one state by a measurement of it, unless the measurement is absurd."""
        ekf, h = self._filter, np.eye(STATE)[what : what + 1]
        off = value - float(ekf.x[what])
        off = math.remainder(off, math.tau) if angle else off
        if off**2 > GATE_1 * (float(ekf.P[what, what]) + sigma**2):
            return
        z = np.array([float(ekf.x[what]) + off])
        ekf.update(z, lambda _: h, lambda x: x[what : what + 1], R=np.array([[sigma**2]]))

    def _compare(self, off: Floats) -> None:
        """Compare a fix with those before it. `off`: how far it is from the predicted position (m)."""
        self._offs.append(off)
        if len(self._offs) < RECENT_FIXES:
            return
        offs = np.array(self._offs)
        # The median ignores single jumps; 1.48 makes it a standard deviation (Rousseeuw and Croux 1993).
        scatter = float(1.4826 * np.median(np.abs(offs - np.median(offs, axis=0)), axis=0).max())
        self.doubts_fixes = scatter > (AGREE if self.doubts_fixes else SCATTER) * self._rig.gnss_noise_m

    def _refuse(self) -> None:
        self.refused_fixes += 1
        self._refused_in_a_row += 1
        if self._refused_in_a_row >= REFUSED_IN_A_ROW:
            self._filter.P[:2, :2] *= 4.0
