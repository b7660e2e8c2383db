"""Localizes the vehicle with an extended Kalman filter over satellites, inertial sensors, compass and wheels."""

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
    predict_state,
    process_noise,
)
from stucksolver_perception.measurements import Floats, GnssFix, ImuSample, PoseEstimate, WheelSpeed
from stucksolver_perception.rig import Rig

REAR_AXLE_M = 1.45
"""Distance of the rear axle behind the reference point (m): half of a usual wheelbase of 2.9 m."""
COMPASS_RAD = 0.05
"""Standard deviation of the compass (rad). Ours."""
COMPASS_PERIOD_S = 1.0
"""Time between two uses of the compass (s), because its errors persist. Ours."""
GYRO_OFFSET_RPS = 0.01
"""Initial standard deviation of the gyro's offset (rad/s). Ours."""
ACCELERATION_OFFSET_MPS2 = 0.5
"""Initial standard deviation of the accelerometer's offset, with the share of gravity on slopes (m/s²). Ours."""
GATE_2 = 18.42
"""Limit of chi-square with 2 degrees of freedom: one good fix in ten thousand is rejected."""
GATE_1 = 15.14
"""Limit of chi-square with 1 degree of freedom: one good measurement in ten thousand is rejected."""
MAX_REJECTED_FIXES = 20
"""Number of consecutive rejected fixes after which the filter counts as wrong and widens its covariance. Ours."""
RECENT_FIXES = 20
"""Number of fixes that are compared with each other, in one second. Ours."""
SCATTER, SCATTER_END = 2.5, 1.6
"""Scatter of the fixes, in standard deviations of their noise, above which they are wrong, not the filter, and below
which they are used again. Until then the pose comes from wheels and gyro, with an error of about a meter after some
hundred meters. If the filter is wrong, all fixes have the same error. Ours."""
STATIONARY_SAMPLES = 10
"""Number of wheel speeds and accelerations that decide whether the vehicle is stopped. Ours."""
STATIONARY_SDS = 3.0
"""Maximum mean of these speeds, in its standard deviations. Ours."""
STEADY_MPS2 = 0.1
"""Maximum change of these accelerations (m/s²). The acceleration of a starting vehicle changes before its wheel speeds
do. Ours."""
STANDSTILL_MPS = 0.005
"""Standard deviation of the speed of a stopped vehicle (m/s). Ours."""
HEIGHT_GAIN_S = 5.0
"""Averaging time of heights (s). Ours."""
STALE_S = 0.1
"""Maximum age of data, relative to the state (s). Ours."""


class NotLocalizedError(RuntimeError):
    """There is no pose yet. The message names the missing data."""


class EkfLocalizer:
    """Localizer of one vehicle. Pass every sample in order of time; call `estimate` at any time.

    The inertial sensors predict the state, with one offset of the gyro and one of the accelerometer, which includes the
    share of gravity on slopes. Wheels, fixes and, once per second, the compass correct it. While the vehicle is
    stopped, the speed is held at zero and the gyro's offset is measured (zero-velocity update).
    """

    def __init__(self, rig: Rig, start: PoseEstimate | None = None, rear_axle_m: float = REAR_AXLE_M) -> None:
        """Start at the pose `start`, or with the first fix and the first compass value."""
        self._rig = rig
        self._rear_axle_m = rear_axle_m
        self._filter: Any = None
        self._time_s = 0.0
        self._z_m = 0.0
        self._height_s = 0.0
        self._inertial = (0.0, 0.0)
        """The last measured acceleration along the heading (m/s²) and yaw rate (rad/s)."""
        self._step_error = (0.0, 0.0)
        """Their maximum differences from the mean over the last step."""
        self._yaw_rad: float | None = None
        self._fix: GnssFix | None = None
        self._compass_s = -math.inf
        self._wheels: deque[float] = deque(maxlen=STATIONARY_SAMPLES)
        self._accelerations: deque[float] = deque(maxlen=STATIONARY_SAMPLES)
        self._rejected_in_a_row = 0
        self._fix_residuals: deque[Floats] = deque(maxlen=RECENT_FIXES)
        """Differences of the last fixes from the predicted positions (m)."""
        self.doubts_fixes = False
        """True if the fixes contradict each other, so that none is used."""
        self.rejected_fixes = 0
        """Number of fixes that were not used."""
        if start is not None:
            self._start_at(start)

    @property
    def ready(self) -> bool:
        """True if there is a pose."""
        return self._filter is not None

    @property
    def stands(self) -> bool:
        """True if wheel speeds and accelerations show that the vehicle is stopped."""
        if len(self._wheels) < STATIONARY_SAMPLES or not self._accelerations:
            return False
        max_mean_mps = STATIONARY_SDS * self._rig.wheel_speed_noise_mps / math.sqrt(STATIONARY_SAMPLES)
        max_change_mps2 = max(STEADY_MPS2, 6.0 * self._rig.imu_acceleration_noise_mps2)
        is_rolling = abs(sum(self._wheels) / STATIONARY_SAMPLES) > max_mean_mps
        return not is_rolling and max(self._accelerations) - min(self._accelerations) < max_change_mps2

    def imu(self, sample: ImuSample) -> None:
        """Predict to the sample's time with its acceleration and yaw rate."""
        before = self._inertial
        self._inertial = (sample.acceleration_mps2[0], sample.rotation_rps[2])
        self._accelerations.append(sample.acceleration_mps2[0])
        if sample.compass_rad is not None and self._yaw_rad is None:
            self._yaw_rad = sample.compass_rad
        if not self.ready:
            self._start_from_sensors()
            return
        # A sample is the mean over the step that ends with it, because inertial sensors integrate. Half of its
        # difference from the sample before may be an error, because a simulator may report the value at the step's end.
        self._step_error = (abs(self._inertial[0] - before[0]) / 2.0, abs(self._inertial[1] - before[1]) / 2.0)
        self._advance(sample.time_s, self._inertial)
        if self.stands:
            self._update_stationary(sample)
        if sample.compass_rad is not None and sample.time_s - self._compass_s >= COMPASS_PERIOD_S - 1e-6:
            self._compass_s = sample.time_s
            self._update_state(YAW, sample.compass_rad, COMPASS_RAD, angle=True)

    def wheel(self, speed: WheelSpeed) -> None:
        """Correct the speed with that of the wheels."""
        self._wheels.append(speed.speed_mps)
        if self.ready and self._predict_to(speed.time_s):
            self._update_state(SPEED, speed.speed_mps, self._rig.wheel_speed_noise_mps)

    def gnss(self, fix: GnssFix) -> None:
        """Correct the position with a fix, unless the vehicle cannot be there."""
        if not self.ready:
            self._fix = fix
            self._start_from_sensors()
            return
        if not self._predict_to(fix.time_s):
            return
        ekf, h = self._filter, np.eye(STATE)[:2]
        r = np.eye(2) * self._rig.gnss_noise_m**2
        z = np.array([fix.x_m, fix.y_m])
        residual = z - ekf.x[:2]
        self._check_scatter(residual)
        if self.doubts_fixes:
            self.rejected_fixes += 1
            self._rejected_in_a_row = 0
            return
        if float(residual @ np.linalg.solve(ekf.P[:2, :2] + r, residual)) > GATE_2:
            self._reject()
            return
        self._rejected_in_a_row = 0
        ekf.update(z, lambda _: h, lambda x: x[:2], R=r)
        self._z_m += (fix.z_m - self._z_m) * min(1.0, max(0.0, fix.time_s - self._height_s) / HEIGHT_GAIN_S)
        self._height_s = fix.time_s

    def estimate(self, time_s: float) -> PoseEstimate:
        """Return the pose at a time (s), predicted from the last sample. The filter does not change.

        Raises:
            NotLocalizedError: There was no fix or no compass value yet.
        """
        if not self.ready:
            missing = "a fix" if self._fix is None else "a compass value"
            raise NotLocalizedError(f"no pose yet: waiting for {missing}; or give a start")
        ekf, (acceleration, rotation) = self._filter, self._inertial
        x, p, dt = ekf.x, ekf.P, time_s - self._time_s
        if abs(dt) > 1e-6:
            x, f = predict_state(ekf.x, acceleration, rotation, self._rear_axle_m, dt)
            p = f @ p @ f.T + self._noise(dt)
        yaw = math.remainder(float(x[YAW]), math.tau)
        rate = rotation - float(x[GYRO])
        return PoseEstimate(time_s, float(x[X]), float(x[1]), self._z_m, yaw, float(x[SPEED]), rate, p[:4, :4].copy())

    def _start_from_sensors(self) -> None:
        if self._fix is None or self._yaw_rad is None:
            return
        fix, noise = self._fix, self._rig.gnss_noise_m**2
        speed = self._wheels[-1] if self._wheels else 0.0
        # Without wheel data the speed is unknown.
        speed_variance = self._rig.wheel_speed_noise_mps**2 if self._wheels else 10.0**2
        covariance = np.diag([noise, noise, COMPASS_RAD**2, speed_variance])
        self._start_at(PoseEstimate(fix.time_s, fix.x_m, fix.y_m, fix.z_m, self._yaw_rad, speed, 0.0, covariance))
        self._compass_s = fix.time_s

    def _start_at(self, start: PoseEstimate) -> None:
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
        after, ekf.F = predict_state(ekf.x, inertial[0], inertial[1], self._rear_axle_m, dt)
        ekf.Q = self._noise(dt)
        ekf.predict()
        # filterpy's step is linear, so that only its covariance is correct. The state of the model replaces its state.
        ekf.x = after
        self._time_s = time_s

    def _noise(self, dt: float) -> Floats:
        acceleration = math.hypot(self._rig.imu_acceleration_noise_mps2, self._step_error[0])
        rotation = math.hypot(self._rig.imu_rotation_noise_rps, self._step_error[1])
        return process_noise(self._filter.x, acceleration, rotation, dt)

    def _update_stationary(self, sample: ImuSample) -> None:
        """Correct speed and offsets of a stopped vehicle: its gyro and accelerometer measure their offsets."""
        self._update_state(SPEED, 0.0, STANDSTILL_MPS)
        self._update_state(GYRO, sample.rotation_rps[2], self._rig.imu_rotation_noise_rps)
        self._update_state(ACCELERATION, sample.acceleration_mps2[0], 0.05)

    def _predict_to(self, time_s: float) -> bool:
        """Predict the state to a measurement's time. Return False if the measurement is too old."""
        self._advance(time_s, self._inertial)
        return time_s >= self._time_s - STALE_S

    def _update_state(self, index: int, value: float, sigma: float, angle: bool = False) -> None:
        """Correct one value of the state with its measurement, unless the measurement is not plausible."""
        ekf, h = self._filter, np.eye(STATE)[index : index + 1]
        residual = value - float(ekf.x[index])
        residual = math.remainder(residual, math.tau) if angle else residual
        if residual**2 > GATE_1 * (float(ekf.P[index, index]) + sigma**2):
            return
        z = np.array([float(ekf.x[index]) + residual])
        ekf.update(z, lambda _: h, lambda x: x[index : index + 1], R=np.array([[sigma**2]]))

    def _check_scatter(self, residual: Floats) -> None:
        """Compare a fix with those before it. `residual` (2,) is its difference from the predicted position (m)."""
        self._fix_residuals.append(residual)
        if len(self._fix_residuals) < RECENT_FIXES:
            return
        residuals = np.array(self._fix_residuals)
        # The median ignores single jumps; 1.48 converts it to a standard deviation (Rousseeuw and Croux 1993).
        scatter = float(1.4826 * np.median(np.abs(residuals - np.median(residuals, axis=0)), axis=0).max())
        self.doubts_fixes = scatter > (SCATTER_END if self.doubts_fixes else SCATTER) * self._rig.gnss_noise_m

    def _reject(self) -> None:
        self.rejected_fixes += 1
        self._rejected_in_a_row += 1
        if self._rejected_in_a_row >= MAX_REJECTED_FIXES:
            self._filter.P[:2, :2] *= 4.0
