"""Applies what a passenger said about how far, how fast and how long to a plan. The guard then judges the result."""

from __future__ import annotations

from typing import Any

from stucksolver.plan.behaviors import Nudge, Wait, parse_behavior
from stucksolver.plan.behaviors.behavior import Behavior
from stucksolver.plan.decision import Decision, RecoveryPlan
from stucksolver.plan.intent_authorization import DOES
from stucksolver.scene import Scene
from stucksolver.scene.interpretation import GuidanceIntent, GuidanceLimits, Interpretation

ABOVE = 0.1
"""Distance from a bound that a parameter must exceed, in the parameter's own unit."""


def apply_guidance_limits(plan: RecoveryPlan, reading: Interpretation | None) -> RecoveryPlan:
    """Return the plan with its parameters as the words want them, each within its behavior's bounds.

    A speed is only ever lowered, in every behavior. A distance counts for the behavior that the words ask for, and to
    the side for one that moves aside within the lane. A time counts for a stop where somebody gets out.

    Args:
        plan: A reasoner's plan.
        reading: The words in force, if there are any.
    """
    if reading is None or reading.limits is None:
        return plan
    wanted = tuple(_as_said(behavior, reading, reading.limits) for behavior in plan.behaviors)
    return plan if wanted == plan.behaviors else plan.model_copy(update={"behaviors": wanted})


def apply_limits_to_decision(decision: Decision, scene: Scene) -> Decision:
    """Return a reasoner's decision with its plan as the words in the scene want it. See `apply_guidance_limits`."""
    if decision.plan is None or scene.guidance is None:
        return decision
    plan = apply_guidance_limits(decision.plan, scene.guidance.reading)
    return decision if plan is decision.plan else decision.model_copy(update={"plan": plan})


def _as_said(behavior: Behavior, reading: Interpretation, limits: GuidanceLimits) -> Behavior:
    changes: dict[str, float] = {}
    speed_mps = getattr(behavior, "speed_mps", None)
    if limits.speed_mps is not None and speed_mps is not None:
        changes["speed_mps"] = min(speed_mps, _bounded(behavior, "speed_mps", limits.speed_mps))
    if limits.distance_m is not None and isinstance(behavior, DOES.get(reading.intent, ())):
        aside = isinstance(behavior, Nudge) and reading.side is not None
        name = "offset_m" if aside else "distance_m"
        if aside or (reading.intent is not GuidanceIntent.OVERTAKE and hasattr(behavior, name)):
            changes[name] = _bounded(behavior, name, limits.distance_m)
    if limits.wait_s is not None and isinstance(behavior, Wait) and reading.intent is GuidanceIntent.LET_ME_OUT:
        changes["duration_s"] = _bounded(behavior, "duration_s", limits.wait_s)
    return parse_behavior({**behavior.model_dump(), **changes}) if changes else behavior


def _bounded(behavior: Behavior, name: str, value: float) -> float:
    """Return the value within the bounds of a behavior's parameter."""
    schema: dict[str, Any] = type(behavior).model_json_schema()["properties"][name]
    low = schema.get("minimum", schema.get("exclusiveMinimum", 0.0) + ABOVE)
    return float(min(max(value, low), schema["maximum"]))
