"""The uncertainty of a difference between two runs of the same routes: paired bootstrap and permutation test."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

RESAMPLES = 10_000
"""Number of bootstrap samples, and of random sign changes. Ours."""
COVERED = 0.95
"""Coverage of the intervals."""


@dataclass(frozen=True)
class Interval:
    """A mean with the bounds that cover 95 % of the bootstrap means."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Difference:
    """Difference of paired values, second minus first; `p` of the two-sided permutation test."""

    difference: Interval
    p: float
    pairs: int


def bootstrap(groups: Sequence[Sequence[float]], seed: int = 0, resamples: int = RESAMPLES) -> Interval:
    """Return the mean over routes, each with its values for several seeds.

    Routes are drawn with replacement together with their seeds, because seeds of one route are not independent
    (percentile bootstrap; Efron and Tibshirani, "An Introduction to the Bootstrap", 1993).

    Raises:
        ValueError: There are no values.
    """
    means = _means(groups)
    draws = np.random.default_rng(seed).integers(0, len(means), size=(resamples, len(means)))
    resampled = means[draws].mean(axis=1)
    low, high = np.quantile(resampled, [(1 - COVERED) / 2, (1 + COVERED) / 2])
    return Interval(float(means.mean()), float(low), float(high))


def compare_pairs(differences: Sequence[Sequence[float]], seed: int = 0, resamples: int = RESAMPLES) -> Difference:
    """Test whether the mean of differences by route and seed is 0, by flipping the signs of whole routes."""
    means = _means(differences)
    interval = bootstrap(differences, seed, resamples)
    signs = np.random.default_rng(seed + 1).choice([-1.0, 1.0], size=(resamples, len(means)))
    flipped = np.abs((signs * means).mean(axis=1))
    # The observed signs are one of the possible ones (Phipson and Smyth, 2010).
    as_large = int((flipped >= abs(means.mean()) - 1e-12).sum())
    return Difference(interval, (as_large + 1) / (resamples + 1), len(means))


def _means(groups: Sequence[Sequence[float]]) -> NDArray[np.float64]:
    if not groups or not all(len(group) for group in groups):
        raise ValueError("no route has a value to average")
    return np.array([float(np.mean(group)) for group in groups])
