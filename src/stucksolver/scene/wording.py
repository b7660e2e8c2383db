"""Phrases for places and times, as people say them."""

from __future__ import annotations

import math

BESIDE_M = 0.5
"""Nearer than this along the road, something is beside the ego, neither ahead nor behind."""


def whereabouts(ahead_m: float) -> str:
    """Return a distance ahead (m) in words: `12 m ahead`, `beside us`, `3 m behind`."""
    if abs(ahead_m) < BESIDE_M:
        return "beside us"
    return f"{abs(ahead_m):.0f} m {'ahead' if ahead_m > 0.0 else 'behind'}"


def stood_too_briefly(stood_s: float, needed_s: float) -> str:
    """Return `has been stationary for 9 s; 10 s are required`.

    The first number is rounded down and the second one up, so that they never look the same.
    """
    return f"has been stationary for {math.floor(stood_s)} s; {math.ceil(needed_s)} s are required"
