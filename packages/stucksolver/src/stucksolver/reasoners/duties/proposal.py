"""What a duty or a request leads to: a plan, or a wait, with its reason."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan import RecoveryPlan, WaitReason
from stucksolver.plan.behaviors.behavior import Behavior
from stucksolver.scene import Scene


@dataclass(frozen=True)
class Proposal:
    """A plan, or None with the reason to wait.

    Attributes:
        plan: The plan, if there is one.
        why: The reason for the plan or for the wait, in words.
        wait: The reason to wait; None if there is a plan, or if waiting has no typed reason.
    """

    plan: RecoveryPlan | None
    why: str
    wait: WaitReason | None = None


def propose(scene: Scene, why: str, *behaviors: Behavior) -> Proposal:
    """Return a plan of these behaviors, or no plan if the stack does not offer one of them."""
    missing = next((item.name for item in behaviors if not scene.offers(item.name)), None)
    if missing is not None:
        return Proposal(None, f"the stack does not offer {missing}")
    return Proposal(RecoveryPlan(behaviors=behaviors), why)
