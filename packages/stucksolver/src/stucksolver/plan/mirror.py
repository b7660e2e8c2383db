"""Mirrors answers for left-hand traffic, as `stucksolver.scene.mirror` mirrors the inputs.

All functions are their own inverse.
"""

from __future__ import annotations

from stucksolver.plan.behaviors import Behavior
from stucksolver.plan.decision import Decision, Participant, RecoveryPlan
from stucksolver.plan.directive import Directive, Execute
from stucksolver.scene.mirror import mirrored_relation, with_sides_swapped


def mirrored_directive(directive: Directive) -> Directive:
    """Return a directive with its path in the mirror: y -> -y (m). A directive without a path is returned as it is."""
    if not isinstance(directive, Execute) or not directive.path:
        return directive
    path = tuple(point.model_copy(update={"y_m": -point.y_m}) for point in directive.path)
    return directive.model_copy(update={"path": path, "behavior": mirrored_behavior(directive.behavior)})


def mirrored_plan(plan: RecoveryPlan) -> RecoveryPlan:
    """Return a plan whose behaviors go to the other side."""
    return plan.model_copy(update={"behaviors": tuple(map(mirrored_behavior, plan.behaviors))})


def mirrored_behavior(behavior: Behavior) -> Behavior:
    """Return a behavior with the other `side`, or the same behavior if it has no such parameter."""
    side = getattr(behavior, "side", None)
    if side not in ("left", "right"):
        return behavior
    return behavior.model_copy(update={"side": "left" if side == "right" else "right"})


def mirrored_decision(decision: Decision) -> Decision:
    """Return a decision in the mirror: its plan, the lanes of its participants, and the sides in its texts."""
    observation, analysis = decision.observation, decision.analysis
    steps = tuple(step.model_copy(update={"evidence": with_sides_swapped(step.evidence)}) for step in analysis.steps)
    return decision.model_copy(
        update={
            "observation": observation.model_copy(
                update={
                    "participants": tuple(map(_participant, observation.participants)),
                    "summary": with_sides_swapped(observation.summary),
                    "picture_only": tuple(
                        obj.model_copy(update={"bearing_deg": -obj.bearing_deg}) for obj in observation.picture_only
                    ),
                }
            ),
            "analysis": analysis.model_copy(update={"steps": steps, "reason": with_sides_swapped(analysis.reason)}),
            "plan": None if decision.plan is None else mirrored_plan(decision.plan),
            "rationale": with_sides_swapped(decision.rationale),
        }
    )


def _participant(participant: Participant) -> Participant:
    return participant.model_copy(update={"lane": mirrored_relation(participant.lane)})
