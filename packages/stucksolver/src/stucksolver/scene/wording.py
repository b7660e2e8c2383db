"""Phrases for people about positions, times and errors."""

from __future__ import annotations

import math

from pydantic import ValidationError

from stucksolver.scene.base_model import first_problem

BESIDE_M = 0.5
"""Distance along the road below which an object is beside the ego, neither ahead nor behind (m). Ours."""
LONGEST_LINE = 300
"""Maximum length of an error's text (characters); the rest is cut off. Ours."""


def whereabouts(ahead_m: float) -> str:
    """Return a distance ahead (m) in words: `12 m ahead`, `beside the ego`, `3 m behind`."""
    if abs(ahead_m) < BESIDE_M:
        return "beside the ego"
    return f"{abs(ahead_m):.0f} m {'ahead' if ahead_m > 0.0 else 'behind'}"


def stood_too_briefly(stood_s: float, needed_s: float) -> str:
    """Return `has been stationary for 9 s; 10 s are required`.

    The first number is rounded down and the second one up, so that they are never equal.
    """
    return f"has been stationary for {math.floor(stood_s)} s; {math.ceil(needed_s)} s are required"


def in_one_line(error: BaseException) -> str:
    """Return an error of any origin as one short line: its type and its message."""
    return f"{type(error).__name__}: {error_text(error)}"


def error_text(error: BaseException) -> str:
    """Return the message of an error as one short line.

    Its own methods may raise or return anything, because it may come from a stack, a listener or a reasoner.
    """
    try:
        text = first_problem(error) if isinstance(error, ValidationError) else str(error)
        text = " ".join(text[: 2 * LONGEST_LINE].split())[:LONGEST_LINE]
    except Exception:  # noqa: BLE001 - a text that cannot be made must not end the control loop
        text = "its message cannot be read"
    return text.encode("utf-8", "backslashreplace").decode()
