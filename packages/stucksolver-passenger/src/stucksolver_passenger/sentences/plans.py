"""Sentences about a plan, in the future and during its execution."""

from __future__ import annotations

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import Behavior


def future_phrase(plan: RecoveryPlan) -> str:
    """Return the parts of a plan in order, to complete "I will"."""
    parts = list(dict.fromkeys(_filled(behavior.phrase.future, behavior) for behavior in plan.behaviors))
    return parts[0] if len(parts) == 1 else ", then ".join([", ".join(parts[:-1]), parts[-1]])


def present_phrase(behavior: Behavior) -> str:
    """Return the behavior in execution: `I am going round it on the left.`"""
    return f"I am {_filled(behavior.phrase.present, behavior)}."


def _filled(text: str, behavior: Behavior) -> str:
    """Return the text with the behavior's parameters in place of their names in braces."""
    return text.format_map(behavior.model_dump(mode="json"))
