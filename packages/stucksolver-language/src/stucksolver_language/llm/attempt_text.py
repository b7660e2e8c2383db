"""Plans that failed, as lines of the prompt: with their parameters, and with the amount that was missing."""

from __future__ import annotations

import json

from stucksolver.plan.plan_text import amount_text, shortened, values_text
from stucksolver.scene import FailedAttempt, Scene

MOST_FAILED = 3
"""Number of failed plans in a prompt, the latest ones. Ours."""
MOST_OUTCOME = 240
"""Longest reason (characters). Amounts stand before it, so that a cut never removes them. Ours."""
FAILED = "failed so far:"


def failed_lines(scene: Scene) -> list[str]:
    """Return the latest failed plans of the intervention, oldest first.

    They have room of their own: they never push an object out of the prompt.
    """
    latest = scene.attempts[-MOST_FAILED:]
    return [FAILED, *(_line(attempt, scene.time_s) for attempt in latest)] if latest else []


def _line(attempt: FailedAttempt, now_s: float) -> str:
    amounts = ",".join(f" {item.code.value}{amount_text(item.amount, item.unit)}" for item in attempt.missing)
    reason = shortened(attempt.outcome, MOST_OUTCOME)
    ago_s = max(now_s - attempt.time_s, 0.0)
    ended = f"{attempt.ended.value} {ago_s:.0f} s ago"
    return f"{_plan(attempt)}: {ended}{',' if amounts else ''}{amounts}; {reason}"


def _plan(attempt: FailedAttempt) -> str:
    """Return the behaviors with their values, or their names alone in an old record."""
    if len(attempt.plan) != len(attempt.behaviors):
        return "+".join(attempt.behaviors)
    return "+".join(values_text(json.loads(behavior)) for behavior in attempt.plan)
