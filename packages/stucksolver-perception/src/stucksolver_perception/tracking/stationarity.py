"""Decides whether an object is stationary or moves: tests on its last detections, with a stated error probability.

A parked car must not appear to move because detections are noisy, and a car that pulls away must be noticed soon. One
test does both: the generalized likelihood ratio of "it is stationary" against "it began to accelerate at some moment"
or "it drives slowly" (Willsky & Jones, "A generalized likelihood ratio approach to the detection and estimation of
jumps in linear systems", 1976), over positions and measured velocities of the last seconds.

Errors that all looks share cancel: the position itself is unknown in the tests, so a constant offset of the boxes does
no harm, and a common error of the velocities is allowed for.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Floats

SAMPLES = 32
"""Detections that are kept: 3 s at 10 Hz."""
WINDOW_S = 3.0
"""Older detections are not used (s): since then the ego's own pose may have drifted."""
ONSETS_S = np.arange(0.3, 2.01, 0.2)
"""How long ago the acceleration may have begun (s)."""
STANDING_MPS = 0.1
"""Slower objects count as stationary, as in the privileged tracker (m/s)."""
FALSE_ALARM = 1e-5
"""Probability that one test calls a stationary object moving, if the noise is as assumed. Tests of consecutive looks
share most of their data, so that there are about two independent ones a second."""
ALARM = -2.0 * float(np.log(FALSE_ALARM))
"""The same as a limit of chi-square with 2 degrees of freedom."""
SHARED_VELOCITY_MPS = 1.0
"""Standard deviation of the error that all velocities of one parked vehicle share (see `noise.py`)."""
DRIFT_PER_S = 0.5
"""Share of the position's standard deviation by which a box drifts over its body within a second, as the ego passes and
sees another side of it. Such a drift does not count as motion.
"""
FREE = 1e6
"""Variance of unknown quantities (m²)."""
REST_S = 1.0
"""Whether it is stationary is decided over this span (s), or the whole window if detections are too noisy for that."""
REST_SIGMA_MPS = 0.18
"""It is decided only if the speed over that span is known this well (m/s)."""
REST_SIGMAS = 1.64
USUAL_LOOKS = 10.0
"""The noise counts as normal until more looks than this indicate otherwise."""


class MotionState(Enum):
    """What is known about whether an object moves."""

    UNDECIDED = "undecided"
    STANDING = "standing"
    MOVING = "moving"


@dataclass(frozen=True, eq=False)
class Evidence:
    """The tests' results for n objects."""

    moves: NDArray[np.bool_]
    """(n,): True if the hypothesis that it is stationary is rejected."""
    rests: NDArray[np.bool_]
    """(n,): True if its speed is known well and consistent with zero, over the last second or the whole window."""
    rests_since_s: Floats
    """(n,): the first consistent detection; meaningful only if it rests."""
    velocity: Floats
    """(n, 2): the best estimate of its velocity if it moves (m/s)."""
    variance: Floats
    """(n,): variance of each of its components (m²/s²)."""


def judge(samples: Floats, now_s: float) -> Evidence:
    """Test n objects at once.

    `samples` is (n, SAMPLES, 7): time (-inf where there is none), x, y, vx, vy in the local frame, and the variances of
    one coordinate of the position (m²) and of the velocity (m²/s²).
    """
    time = samples[..., 0] - now_s
    known = time > -WINDOW_S
    time = np.where(known, time, 0.0)
    place = np.where(known[..., None], samples[..., 1:3], 0.0)
    place = place - (place.sum(1) / np.maximum(1, known.sum(1))[:, None])[:, None] * known[..., None]
    velocity = np.where(known[..., None], samples[..., 3:5], 0.0)
    excess = _excess(place, velocity, samples, known)
    by_place = np.where(known, 1.0 / np.maximum(1e-9, samples[..., 5] * excess[0][:, None]), 0.0)
    by_speed = np.where(known, 1.0 / np.maximum(1e-9, samples[..., 6] * excess[1][:, None]), 0.0)

    # It began to accelerate some time ago.
    driven = np.maximum(0.0, time[:, None] + ONSETS_S[:, None])
    gain, variance = _fit(driven**2 / 2.0, driven, place, velocity, by_place, by_speed)
    drift = (DRIFT_PER_S**2 * np.where(known, samples[..., 5], 0.0).sum(1) / np.maximum(1, known.sum(1)))[:, None]
    best = ((gain**2).sum(-1) / variance).argmax(1)
    started = ((gain**2).sum(-1) / (variance + drift * (2.0 / ONSETS_S) ** 2)).max(1)
    rows = np.arange(len(samples))
    start_velocity = gain[rows, best] * ONSETS_S[best][:, None]
    start_variance = variance[rows, best] * ONSETS_S[best] ** 2

    # It drives at a steady speed: over the whole window, and over its last second.
    item = np.ones_like(time)
    slow, slow_variance = _steady(time, item, place, velocity, by_place, by_speed)
    late = time > -REST_S - 1e-6
    last, last_variance = _steady(time, item, place, velocity, by_place * late, by_speed * late)
    drives = _drives(slow, slow_variance + drift[:, 0])
    hurries = _drives(last, last_variance + drift[:, 0])
    most = np.maximum(started, np.maximum(drives, hurries))
    by_start = started >= np.maximum(drives, hurries)
    may_drift = np.sqrt(drift[:, 0])
    briefly, long = _rests(last, last_variance, may_drift), _rests(slow, slow_variance, may_drift)
    first = np.where(known, time, 0.0).min(1)
    first_late = np.where(known & late, time, 0.0).min(1)
    return Evidence(
        moves=most > ALARM,
        rests=briefly | long,
        rests_since_s=now_s + np.where(long, first, first_late),
        velocity=np.where(by_start[:, None], start_velocity, last),
        variance=np.where(by_start, start_variance, last_variance),
    )


def _drives(velocity: Floats, variance: Floats) -> Floats:
    """(n,): chi-square of a steady speed above `STANDING_MPS`."""
    return np.asarray(np.maximum(0.0, np.hypot(velocity[:, 0], velocity[:, 1]) - STANDING_MPS) ** 2 / variance)


def _rests(velocity: Floats, variance: Floats, drift_mps: Floats) -> NDArray[np.bool_]:
    sigma = np.sqrt(variance)
    agrees = np.hypot(velocity[:, 0], velocity[:, 1]) < STANDING_MPS + REST_SIGMAS * sigma + drift_mps
    return np.asarray(agrees & (sigma < REST_SIGMA_MPS))


def _steady(
    time: Floats, box: Floats, place: Floats, velocity: Floats, by_place: Floats, by_speed: Floats
) -> tuple[Floats, Floats]:
    speed, variance = _fit(time[:, None], box[:, None], place, velocity, by_place, by_speed)
    return speed[:, 0], variance[:, 0]


def _fit(
    moved: Floats, sped: Floats, place: Floats, velocity: Floats, by_place: Floats, by_speed: Floats
) -> tuple[Floats, Floats]:
    """Generalized least squares for one vector g: place = offset + g * moved, velocity = shared + g * sped.

    `moved` and `sped` are (n, k, w) for k hypotheses, `place` and `velocity` (n, w, 2), `by_*` (n, w) inverse
    variances. Returns g (n, k, 2) and the variance (n, k) of each of its components.
    """
    information, weighted = _normal(moved, place, by_place, FREE)
    more, weighted_too = _normal(sped, velocity, by_speed, SHARED_VELOCITY_MPS**2)
    information = np.maximum(1e-9, information + more)
    return (weighted + weighted_too) / information[..., None], 1.0 / information


def _normal(shape: Floats, residual: Floats, by: Floats, shared: float) -> tuple[Floats, Floats]:
    """Normal equations if all samples share an unknown offset of variance `shared` (Woodbury's identity)."""
    weights = by.sum(-1)
    held = (shared / (1.0 + shared * weights))[:, None]
    weighted = shape * by[:, None]
    sums = weighted.sum(-1)
    residuals = (residual * by[..., None]).sum(1)
    information = (weighted * shape).sum(-1) - sums**2 * held
    return information, weighted @ residual - (sums * held)[..., None] * residuals[:, None]


def _excess(place: Floats, velocity: Floats, samples: Floats, known: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return two arrays (n,): how much larger than assumed the variances are (at least 1), from successive looks.

    Differences do not depend on the object's position and speed: for positions second differences, whose variance is 6
    times that of one sample, for velocities first differences, with twice the variance.
    """
    second = np.diff(place, n=2, axis=1) ** 2 / (6.0 * np.maximum(1e-9, samples[:, 1:-1, 5, None]))
    first = np.diff(velocity, axis=1) ** 2 / (2.0 * np.maximum(1e-9, samples[:, 1:, 6, None]))
    results = []
    for squares, whole in ((second, known[:, :-2]), (first, known[:, :-1])):
        looks = whole.sum(1)
        total = (squares.mean(-1) * whole).sum(1)
        results.append(np.maximum(1.0, (USUAL_LOOKS + total) / (USUAL_LOOKS + looks)))
    return results[0], results[1]
