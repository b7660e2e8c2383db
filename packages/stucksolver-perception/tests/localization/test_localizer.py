from __future__ import annotations

import math

import numpy as np
import pytest
from tests.localization.drives import RIG, drive, error, standing, town

from stucksolver_perception.localization import EkfLocalizer, NotLocalizedError
from stucksolver_perception.measurements import GnssFix, ImuSample, PoseEstimate, WheelSpeed

RUNS = 6


def judged(times, profile, seconds, **more):
    """At these times of some drives: errors (runs, times, 4), NEES (runs, times), and the stated spread."""
    off, nees, spread = [], [], []
    for seed in range(RUNS):
        for t, truth, localizer in drive(seed, profile, seconds, **more):
            if any(abs(t - wanted) < 1e-6 for wanted in times):
                estimate = localizer.estimate(t)
                off.append(error(truth, estimate))
                nees.append(off[-1] @ np.linalg.solve(estimate.covariance, off[-1]))
                spread.append(math.sqrt(np.trace(estimate.covariance[:2, :2])))
    shape = (RUNS, len(times))
    return np.array(off).reshape(*shape, 4), np.array(nees).reshape(shape), np.array(spread).reshape(shape)


LOW, HIGH = 1.5, 8.1
"""Chi-square with 4 degrees of freedom: 99.8 % of the means over 6 independent drives lie between these."""


@pytest.mark.integration
def test_localizer_error_after_10_s_is_small_and_consistent():
    """After ten seconds of driving, the error is small and the stated uncertainty fits it."""
    off, nees, _ = judged(np.arange(4.0, 12.01, 1.0), town, 12.05, gyro=0.004, slope=0.4)
    assert math.sqrt((off[:, 6, :2] ** 2).sum(-1).mean()) < 0.4
    assert np.abs(off[..., 2]).max() < 0.06
    # Looks of one drive depend on each other: the mean over all varies less than that over the drives.
    assert LOW < nees.mean() < HIGH


@pytest.mark.integration
def test_a_vehicle_that_stands_does_not_wander():
    places = []
    for t, truth, localizer in drive(1, standing, 60.0, gyro=0.004, slope=0.4):
        if t > 10.0:
            estimate = localizer.estimate(t)
            places.append(error(truth, estimate)[:3])
    places = np.array(places)
    assert np.hypot(places[:, 0], places[:, 1]).max() < 0.25
    assert np.abs(np.diff(places[:, :2], axis=0)).max() < 0.01
    assert np.ptp(places[:, 2]) < 0.03


@pytest.mark.integration
def test_localizer_without_satellites_states_growing_uncertainty():
    """Without satellites, the localizer goes on and states how uncertain it is."""

    def cruise(t, speed):
        return (2.0 if speed < 10.0 else 0.0), town(t, speed)[1]

    off, nees, spread = judged([8.0, 18.0, 28.0], cruise, 28.05, fix=lambda t: t < 8.01)
    assert np.sqrt((off[:, 2, :2] ** 2).sum(-1).mean()) < 4.0
    assert LOW < nees[:, 1:].mean() < HIGH
    assert (spread[:, 1] > 1.5 * spread[:, 0]).all()
    assert (spread[:, 2] > spread[:, 1]).all()


def test_fixes_ten_metres_off_are_refused_and_counted():
    worst = 0.0
    for t, truth, localizer in drive(
        3, town, 20.0, spoilt=lambda t: 10.0 if t > 9.0 and round(t / 0.05) % 10 == 0 else 0
    ):
        if t > 9.0:
            worst = max(worst, float(np.hypot(*error(truth, localizer.estimate(t))[:2])))
    assert localizer.rejected_fixes >= 22
    assert worst < 1.0


@pytest.mark.parametrize("spread_m", [4.0, 8.0, 20.0])
def test_fixes_that_contradict_each_other_are_not_used(spread_m):
    """All of them jump, so most are off by more than the gate allows, and some are within it by chance."""
    rng, worst, doubted = np.random.default_rng(7), 0.0, []
    for t, truth, localizer in drive(7, town, 40.0, spoilt=lambda t: rng.normal(0.0, spread_m) if t > 9.0 else 0.0):
        doubted.append((t, localizer.doubts_fixes))
        if t > 9.0:
            worst = max(worst, float(np.hypot(*error(truth, localizer.estimate(t))[:2])))
    assert not any(doubts for t, doubts in doubted if t < 9.0)
    assert all(doubts for t, doubts in doubted if t > 11.0)
    assert worst < 3.0


def test_fixes_are_used_again_when_they_agree():
    rng = np.random.default_rng(8)
    for t, truth, localizer in drive(8, town, 40.0, spoilt=lambda t: rng.normal(0.0, 8.0) if 9.0 < t < 25.0 else 0.0):  # noqa: B007
        pass
    assert not localizer.doubts_fixes
    assert np.hypot(*error(truth, localizer.estimate(t))[:2]) < 0.8


def test_localizer_lost_recovers_when_all_fixes_disagree():
    """A lost filter recovers when all fixes disagree with it."""
    wrong = PoseEstimate(0.0, 50.0, 0.0, 0.0, 0.0, 0.0, 0.0, np.diag([0.1, 0.1, 0.01, 0.01]))
    localizer = EkfLocalizer(RIG, wrong)
    rng = np.random.default_rng(4)
    for k in range(200):
        t = 0.05 * (k + 1)
        localizer.imu(ImuSample(t, (0.0, 0.0, 9.81), (0.0, 0.0, 0.0), 0.0))
        localizer.gnss(GnssFix(t, rng.normal(0, 0.55), rng.normal(0, 0.55), 0.0))
    assert abs(localizer.estimate(10.0).x_m) < 1.0


def test_the_offsets_are_found_while_it_stands():
    for t, _, localizer in drive(5, standing, 5.0, gyro=0.008):
        last = localizer.estimate(t)
    assert localizer.stands
    assert abs(last.yaw_rate_rps) < 0.004
    assert abs(last.speed_mps) < 0.01


def test_a_vehicle_that_creeps_does_not_count_as_standing():
    def creeping(_, speed):
        return (0.5 if speed < 0.15 else 0.0), 0.0

    for t, truth, localizer in drive(6, creeping, 10.0):  # noqa: B007
        last = localizer.estimate(t)
    assert not localizer.stands
    assert last.speed_mps == pytest.approx(truth[3], abs=0.05)


def test_before_the_first_fix_and_the_first_compass_there_is_no_pose_and_it_says_what_is_missing():
    localizer = EkfLocalizer(RIG)
    with pytest.raises(NotLocalizedError, match="a fix"):
        localizer.estimate(0.0)
    localizer.gnss(GnssFix(0.0, 3.0, 4.0, 0.0))
    with pytest.raises(NotLocalizedError, match="compass"):
        localizer.estimate(0.0)
    localizer.imu(ImuSample(0.0, (0.0, 0.0, 9.81), (0.0, 0.0, 0.0), 1.2))
    estimate = localizer.estimate(0.0)
    assert (estimate.x_m, estimate.y_m, estimate.yaw_rad) == pytest.approx((3.0, 4.0, 1.2))


def test_localizer_later_estimate_extrapolates_and_keeps_filter():
    """An estimate for later goes on with the speed and leaves the filter unchanged."""
    start = PoseEstimate(0.0, 0.0, 0.0, 0.0, 0.0, 10.0, 0.0, np.diag([0.01, 0.01, 1e-4, 0.01]))
    localizer = EkfLocalizer(RIG, start)
    localizer.wheel(WheelSpeed(0.0, 10.0))
    assert localizer.estimate(0.2).x_m == pytest.approx(2.0, abs=0.01)
    assert localizer.estimate(0.2).covariance[0, 0] > localizer.estimate(0.0).covariance[0, 0]
    assert localizer.estimate(0.0).x_m == pytest.approx(0.0, abs=1e-9)
