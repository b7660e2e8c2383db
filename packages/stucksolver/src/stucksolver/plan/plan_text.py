"""A plan and the guard's assessment of it as one line, for a language model and for logs."""

from __future__ import annotations

from collections.abc import Mapping

from stucksolver.plan.assessment import PlanAssessment, Shortfall
from stucksolver.plan.behaviors import Behavior
from stucksolver.plan.decision import RecoveryPlan

MOST_SHORTFALLS = 3
"""Maximum number of requirements in a line: the guard names the nearest objects first. Ours."""
MOST_DETAIL = 120
"""Longest detail of a requirement (characters). Its amount stands before it, so a cut never removes it. Ours."""


def plan_text(plan: RecoveryPlan) -> str:
    """Return the behaviors with their values, such as `back_up(3, 1.4)+borrow_oncoming_lane(car7, 5.5)`."""
    text = "+".join(map(behavior_text, plan.behaviors))
    return f"{text}, route from {plan.route_start or 'here'}" if plan.replan_route else text


def behavior_text(behavior: Behavior) -> str:
    """Return a behavior with its values in the order of its parameters."""
    return values_text(behavior.model_dump(mode="json"))


def values_text(behavior: Mapping[str, object]) -> str:
    """Return the same for the JSON form of a behavior, such as the plan of a failed attempt."""
    values = [value for name, value in behavior.items() if name != "name"]
    return f"{behavior.get('name')}({', '.join(map(_value, values))})"


def assessment_text(assessment: PlanAssessment) -> str:
    """Return what the guard accepts, or what is missing with its amount and unit, in words."""
    reached = _reached(assessment)
    if assessment.accepted:
        return f"accepted: {reached}"
    lacking = "; ".join(map(shortfall_text, assessment.shortfalls[:MOST_SHORTFALLS]))
    at = f" at behavior {assessment.step + 1}" if assessment.step else ""
    if assessment.waits_for_traffic:
        return f"accepted when traffic has passed: {reached}; now {lacking}"
    if assessment.needs_approval:
        return f"accepted if a person approves: {reached}; {lacking}"
    return f"refused{at}: {lacking}"


def shortfall_text(item: Shortfall) -> str:
    """Return a requirement with the amount that is missing first: `gap 0.4 m short (car lead: gap 0.1 m, …)`."""
    return f"{item.code.value}{amount_text(item.missing, item.unit)} ({shortened(item.detail, MOST_DETAIL)})"


def shortened(text: str, most: int) -> str:
    """Return a text of at most `most` characters; a longer one ends with an ellipsis."""
    return text if len(text) <= most else text[: most - 1] + "…"


def amount_text(missing: float | None, unit: str | None) -> str:
    """Return ` 0.4 m short`, or nothing if the requirement has no amount."""
    return "" if missing is None or unit is None else f" {_value(max(missing, 0.1))} {unit} short"


def _reached(assessment: PlanAssessment) -> str:
    """Return time, progress, gaps and margins of the accepted steps."""
    parts = [f"{_value(assessment.duration_s)} s", f"{_value(assessment.progress_m)} m on"]
    parts.append(f"{assessment.free_m:.0f} m free after it")
    if assessment.back_m > 0.0:
        parts.append(f"{_value(assessment.back_m)} m in reverse")
    if assessment.oncoming_m > 0.0:
        parts.append(f"{_value(assessment.oncoming_m)} m in the oncoming lane")
    if assessment.gap_m is not None:
        parts.append(f"gap {_value(assessment.gap_m)} m{_spare(assessment.gap_margin_m)}")
    if assessment.sight_margin_m is not None:
        parts.append(f"sight{_spare(assessment.sight_margin_m)}")
    return ", ".join(parts)


def _spare(margin_m: float | None) -> str:
    return "" if margin_m is None else f" with {_value(max(margin_m, 0.0))} m to spare"


def _value(value: object) -> str:
    """Return a number with at most one decimal, and anything else as it is."""
    if isinstance(value, float):
        text = f"{value:.1f}"
        return "0" if text in ("0.0", "-0.0") else text.removesuffix(".0")
    return "none" if value is None else str(value)
