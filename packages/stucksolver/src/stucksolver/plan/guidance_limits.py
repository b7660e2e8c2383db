"""Applies what a passenger said about how far, how fast and how long to a plan. The guard then judges the result."""

from __future__ import annotations

from typing import Any

from stucksolver.plan.behaviors import Behavior, parse_behavior
from stucksolver.plan.decision import Decision, RecoveryPlan
from stucksolver.scene import Scene
from stucksolver.scene.interpretation import GuidanceLimits, Interpretation

ABOVE = 0.1
"""Distance from a bound that a parameter must exceed, in the parameter's own unit."""


def apply_guidance_limits(plan: RecoveryPlan, reading: Interpretation | None) -> RecoveryPlan:
    """Return the plan with its parameters as the words want them, each within its behaviour's bounds.

    A speed is only ever lowered, in every behaviour. A distance counts for the behaviour that the words ask for, and to
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
    for name, value in behavior.guided_parameters(reading, limits).items():
        changes[name] = _bounded(behavior, name, value)
    return parse_behavior({**behavior.model_dump(), **changes}) if changes else behavior


def _bounded(behavior: Behavior, name: str, value: float) -> float:
    """Return the value within the bounds of a behaviour's parameter."""
    schema: dict[str, Any] = type(behavior).model_json_schema()["properties"][name]
    low = schema.get("minimum", schema.get("exclusiveMinimum", 0.0) + ABOVE)
    return float(min(max(value, low), schema["maximum"]))
