"""Applies the distance, speed and time of a passenger's utterance to a plan. The guard then checks the result."""

from __future__ import annotations

from typing import Any

from stucksolver.plan.behaviors import Behavior, parse_behavior
from stucksolver.plan.decision import Decision, RecoveryPlan
from stucksolver.scene import Scene
from stucksolver.scene.interpretation import GuidanceLimits, Interpretation

ABOVE = 0.1
"""Distance from an exclusive bound that a parameter keeps, in the unit of the parameter. Ours."""


def apply_guidance_limits(plan: RecoveryPlan, reading: Interpretation | None) -> RecoveryPlan:
    """Return the plan with the quantities of the utterance, each within the bounds of its behavior.

    A speed is only ever lowered, in every behavior. A distance applies to the behavior that the intent authorizes. If
    that behavior is a nudge and the utterance has a side, the distance is its lateral offset. A time applies to a stop
    where a passenger gets out.

    Args:
        plan: Plan of a reasoner.
        reading: Interpretation of the current guidance, if there is any.
    """
    if reading is None or reading.limits is None:
        return plan
    wanted = tuple(_as_said(behavior, reading, reading.limits) for behavior in plan.behaviors)
    return plan if wanted == plan.behaviors else plan.model_copy(update={"behaviors": wanted})


def apply_limits_to_decision(decision: Decision, scene: Scene) -> Decision:
    """Return a reasoner's decision with the quantities of the guidance in its scene. See `apply_guidance_limits`."""
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
    """Return the value, clipped to the bounds of a behavior's parameter."""
    schema: dict[str, Any] = type(behavior).model_json_schema()["properties"][name]
    low = schema.get("minimum", schema.get("exclusiveMinimum", 0.0) + ABOVE)
    return float(min(max(value, low), schema["maximum"]))
