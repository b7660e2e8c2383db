"""The success rate of a solution after some tries: a rate with a prior, and its lower confidence bound."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import comb

CONFIDENCE = 0.9
"""One-sided confidence level: probability that the true rate exceeds the lower bound. Ours."""
PROPOSED_FROM = 0.4
"""Lowest confidence bound of a solution that is proposed.

Two successes without a failure exceed it (0.46), and so do three with one failure (0.42). One success (0.32) and two
with one failure (0.32) do not, since they may be chance. Ours.
"""
STEPS = 40
"""Number of bisection steps. They reach 1e-12."""


@dataclass(frozen=True)
class SuccessRate:
    """Number of tries, and number of successes. The prior is uniform: Beta(1, 1)."""

    worked: int = 0
    tries: int = 0

    @property
    def mean(self) -> float:
        """Expected success rate (Laplace's rule of succession)."""
        return (self.worked + 1) / (self.tries + 2)

    @property
    def lower(self) -> float:
        """Lower bound of the true rate, with probability `CONFIDENCE`."""
        return lower_bound(self.worked, self.tries)

    def with_one(self, worked: bool) -> SuccessRate:
        """Return the rate after one more try."""
        return SuccessRate(self.worked + worked, self.tries + 1)


@lru_cache(maxsize=4096)
def lower_bound(worked: int, tries: int) -> float:
    """Return the (1 - CONFIDENCE) quantile of Beta(worked + 1, tries - worked + 1).

    For integer parameters the distribution function is a binomial tail (Abramowitz and Stegun, 26.5.24), so no library
    is needed.

    Raises:
        ValueError: The number of successes exceeds the number of tries.
    """
    if not 0 <= worked <= tries:
        raise ValueError(f"successes must not exceed tries: {worked} of {tries}")
    low, high = 0.0, 1.0
    for _ in range(STEPS):
        middle = (low + high) / 2
        if _below(middle, worked + 1, tries + 1) < 1.0 - CONFIDENCE:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def _below(x: float, successes: int, draws: int) -> float:
    """Return the probability of at least `successes` in `draws`, each with probability `x`."""
    return sum(comb(draws, k) * x**k * (1.0 - x) ** (draws - k) for k in range(successes, draws + 1))
