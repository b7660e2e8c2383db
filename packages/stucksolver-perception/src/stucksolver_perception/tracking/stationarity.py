"""Decides whether objects are stationary, with tests on their last detections and a stated error probability.

A parked car must not seem to move because detections are noisy, and a starting car must be noticed soon. One test does
both. It is the generalized likelihood ratio of "stationary" against "began to accelerate at some time" or "moves
slowly" (Willsky & Jones, "A generalized likelihood ratio approach to the detection and estimation of jumps in linear
systems", 1976), over positions and measured velocities of the last seconds.

Errors common to all detections of an object cancel. The position is unknown in the tests, so that a constant offset of
the boxes has no effect, and the velocities may have a common error.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Floats

SAMPLES = 32
"""Number of stored detections: 3 s at 10 Hz."""
WINDOW_S = 3.0
"""Maximum age of a used detection (s). In a longer time the ego's pose may drift. Ours."""
ONSETS_S = np.arange(0.3, 2.01, 0.2)
"""Times before now at which the acceleration may have begun (s). Ours."""
STATIONARY_MPS = 0.1
"""Speed below which an object counts as stationary (m/s), as in the privileged tracker."""
FALSE_ALARM = 1e-5
"""Probability that a test reports motion of a stationary object, if the noise is as assumed. Consecutive tests share
most of their data, so that about two of them per second are independent."""
ALARM = -2.0 * float(np.log(FALSE_ALARM))
"""Limit of chi-square with 2 degrees of freedom at this probability."""
SHARED_VELOCITY_MPS = 1.0
"""Standard deviation of the common error of a parked vehicle's velocities (m/s); see `noise.py`."""
DRIFT_PER_S = 0.5
"""Drift of a box relative to its object per second, as a share of the position's standard deviation, when the ego
passes and other sides become visible. It does not count as motion. Ours."""
UNKNOWN_VARIANCE = 1e6
"""Variance of unknown quantities (m²)."""
REST_S = 1.0
"""Time over which rest is decided (s). With noisy detections it is decided over the whole window. Ours."""
REST_SD_MPS = 0.18
"""Maximum standard deviation of the speed over that time for a decision (m/s). Ours."""
REST_SDS = 1.64
"""Number of standard deviations of the speed of an object at rest: 95 % of a normal distribution, one-sided."""
PRIOR_SAMPLES = 10.0
"""Weight of the assumed noise, in detections, against the measured one. Ours."""


class MotionState(Enum):
    """State of an object's motion."""

    UNDECIDED = "undecided"
    STANDING = "standing"
    MOVING = "moving"


@dataclass(frozen=True, eq=False)
class Evidence:
    """The tests' results for n objects."""

    moves: NDArray[np.bool_]
    """(n,): True if the hypothesis that the object is stationary is rejected."""
    rests: NDArray[np.bool_]
    """(n,): True if the speed is accurate and consistent with zero, over the last second or the whole window."""
    rests_since_s: Floats
    """(n,): time of the first consistent detection (s); meaningful only for an object at rest."""
    velocity: Floats
    """(n, 2): the best estimate of the velocity of a moving object (m/s)."""
    variance: Floats
    """(n,): variance of each component of the velocity (m²/s²)."""


def motion_evidence(samples: Floats, now_s: float) -> Evidence:
    """Return the tests' results for n objects at once.

    `samples` is (n, SAMPLES, 7): time (-inf for a missing sample), x, y, vx, vy in the local frame, and the variances
    of one coordinate of the position (m²) and of the velocity (m²/s²).
    """
    time = samples[..., 0] - now_s
    is_valid = time > -WINDOW_S
    time = np.where(is_valid, time, 0.0)
    position = np.where(is_valid[..., None], samples[..., 1:3], 0.0)
    position = position - (position.sum(1) / np.maximum(1, is_valid.sum(1))[:, None])[:, None] * is_valid[..., None]
    velocity = np.where(is_valid[..., None], samples[..., 3:5], 0.0)
    excess = _excess_variance(position, velocity, samples, is_valid)
    position_weight = np.where(is_valid, 1.0 / np.maximum(1e-9, samples[..., 5] * excess[0][:, None]), 0.0)
    velocity_weight = np.where(is_valid, 1.0 / np.maximum(1e-9, samples[..., 6] * excess[1][:, None]), 0.0)

    # Hypothesis: the object began to accelerate some time ago.
    since_onset = np.maximum(0.0, time[:, None] + ONSETS_S[:, None])
    acceleration, variance = _fit(
        since_onset**2 / 2.0, since_onset, position, velocity, position_weight, velocity_weight
    )
    drift = (DRIFT_PER_S**2 * np.where(is_valid, samples[..., 5], 0.0).sum(1) / np.maximum(1, is_valid.sum(1)))[:, None]
    best_onset = ((acceleration**2).sum(-1) / variance).argmax(1)
    start_statistic = ((acceleration**2).sum(-1) / (variance + drift * (2.0 / ONSETS_S) ** 2)).max(1)
    rows = np.arange(len(samples))
    start_velocity = acceleration[rows, best_onset] * ONSETS_S[best_onset][:, None]
    start_variance = variance[rows, best_onset] * ONSETS_S[best_onset] ** 2

    # Hypothesis: the object moves at a constant speed, over the whole window or over its last second.
    ones = np.ones_like(time)
    window_velocity, window_variance = _fit_velocity(time, ones, position, velocity, position_weight, velocity_weight)
    is_late = time > -REST_S - 1e-6
    late_velocity, late_variance = _fit_velocity(
        time, ones, position, velocity, position_weight * is_late, velocity_weight * is_late
    )
    window_statistic = _motion_statistic(window_velocity, window_variance + drift[:, 0])
    late_statistic = _motion_statistic(late_velocity, late_variance + drift[:, 0])
    max_statistic = np.maximum(start_statistic, np.maximum(window_statistic, late_statistic))
    is_start = start_statistic >= np.maximum(window_statistic, late_statistic)
    drift_mps = np.sqrt(drift[:, 0])
    rests_late, rests_window = (
        _is_at_rest(late_velocity, late_variance, drift_mps),
        _is_at_rest(window_velocity, window_variance, drift_mps),
    )
    first = np.where(is_valid, time, 0.0).min(1)
    first_late = np.where(is_valid & is_late, time, 0.0).min(1)
    return Evidence(
        moves=max_statistic > ALARM,
        rests=rests_late | rests_window,
        rests_since_s=now_s + np.where(rests_window, first, first_late),
        velocity=np.where(is_start[:, None], start_velocity, late_velocity),
        variance=np.where(is_start, start_variance, late_variance),
    )


def _motion_statistic(velocity: Floats, variance: Floats) -> Floats:
    """Return (n,): chi-square of a constant speed above `STATIONARY_MPS`."""
    return np.asarray(np.maximum(0.0, np.hypot(velocity[:, 0], velocity[:, 1]) - STATIONARY_MPS) ** 2 / variance)


def _is_at_rest(velocity: Floats, variance: Floats, drift_mps: Floats) -> NDArray[np.bool_]:
    sigma = np.sqrt(variance)
    agrees = np.hypot(velocity[:, 0], velocity[:, 1]) < STATIONARY_MPS + REST_SDS * sigma + drift_mps
    return np.asarray(agrees & (sigma < REST_SD_MPS))


def _fit_velocity(
    time: Floats, ones: Floats, position: Floats, velocity: Floats, position_weight: Floats, velocity_weight: Floats
) -> tuple[Floats, Floats]:
    speed, variance = _fit(time[:, None], ones[:, None], position, velocity, position_weight, velocity_weight)
    return speed[:, 0], variance[:, 0]


def _fit(
    position_factor: Floats,
    velocity_factor: Floats,
    position: Floats,
    velocity: Floats,
    position_weight: Floats,
    velocity_weight: Floats,
) -> tuple[Floats, Floats]:
    """Fit one vector g with generalized least squares.

    The model is: position = offset + g * position_factor, velocity = common error + g * velocity_factor. The factors
    are (n, k, w) for k hypotheses, position and velocity (n, w, 2), and the weights (n, w) are inverse variances.
    Return g (n, k, 2), and the variance (n, k) of each of its components.
    """
    from_position, position_sum = _normal_equations(position_factor, position, position_weight, UNKNOWN_VARIANCE)
    from_velocity, velocity_sum = _normal_equations(velocity_factor, velocity, velocity_weight, SHARED_VELOCITY_MPS**2)
    information = np.maximum(1e-9, from_position + from_velocity)
    return (position_sum + velocity_sum) / information[..., None], 1.0 / information


def _normal_equations(
    factor: Floats, residual: Floats, weight: Floats, offset_variance: float
) -> tuple[Floats, Floats]:
    """Return the normal equations for samples with a common unknown offset (Woodbury's identity)."""
    weights = weight.sum(-1)
    reduction = (offset_variance / (1.0 + offset_variance * weights))[:, None]
    weighted = factor * weight[:, None]
    sums = weighted.sum(-1)
    residuals = (residual * weight[..., None]).sum(1)
    information = (weighted * factor).sum(-1) - sums**2 * reduction
    return information, weighted @ residual - (sums * reduction)[..., None] * residuals[:, None]


def _excess_variance(
    position: Floats, velocity: Floats, samples: Floats, is_valid: NDArray[np.bool_]
) -> tuple[Floats, Floats]:
    """Return two arrays (n,): the factors by which the variances of positions and velocities exceed the assumed ones.

    The factors are at least 1. They come from differences of consecutive samples, which do not depend on the object's
    position and speed: second differences of positions, whose variance is 6 times that of one sample, and first
    differences of velocities, with twice the variance.
    """
    second = np.diff(position, n=2, axis=1) ** 2 / (6.0 * np.maximum(1e-9, samples[:, 1:-1, 5, None]))
    first = np.diff(velocity, axis=1) ** 2 / (2.0 * np.maximum(1e-9, samples[:, 1:, 6, None]))
    results = []
    for squares, has_neighbors in ((second, is_valid[:, :-2]), (first, is_valid[:, :-1])):
        count = has_neighbors.sum(1)
        total = (squares.mean(-1) * has_neighbors).sum(1)
        results.append(np.maximum(1.0, (PRIOR_SAMPLES + total) / (PRIOR_SAMPLES + count)))
    return results[0], results[1]
