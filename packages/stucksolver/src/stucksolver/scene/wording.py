"""Phrases for places and times, as people say them."""

from __future__ import annotations

import math

from pydantic import ValidationError

from stucksolver.scene.base_model import first_problem

BESIDE_M = 0.5
"""Nearer than this along the road, something is beside the ego, neither ahead nor behind."""
LONGEST_LINE = 300
"""An error's text is cut after this many characters."""


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


def in_one_line(error: BaseException) -> str:
    """Return an error of whatever origin as one short line: its type and what it says."""
    return f"{type(error).__name__}: {said_by(error)}"


def said_by(error: BaseException) -> str:
    """Return what an error says, as one short line.

    Its own methods may raise or return anything, because it may come from a stack, a listener or a reasoner.
    """
    try:
        text = first_problem(error) if isinstance(error, ValidationError) else str(error)
        text = " ".join(text[: 2 * LONGEST_LINE].split())[:LONGEST_LINE]
    except Exception:  # noqa: BLE001 - a text that cannot be made must not end the control loop
        text = "its message cannot be read"
    return text.encode("utf-8", "backslashreplace").decode()
