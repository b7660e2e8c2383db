"""A solution: the kind of a plan, without its numbers, because another scene needs other numbers."""

from __future__ import annotations

from stucksolver.plan import RecoveryPlan
from stucksolver.scene import DirectedSide, GuidanceIntent
from stucksolver.scene.base_model import FrozenModel


class Solution(FrozenModel):
    """Kind of a plan that moves the vehicle on. `side` is set only if the plan used a side."""

    intent: GuidanceIntent
    side: DirectedSide | None = None

    @property
    def name(self) -> str:
        """Name for people and for the file: `overtake left`, `reroute`."""
        side = "" if self.side is None else f" {self.side.value}"
        return self.intent.value.replace("_", " ") + side


def solution_of(plan: RecoveryPlan) -> Solution | None:
    """Return the solution of a plan; None for a plan that only waits, stops or calls.

    The most significant behavior names it: a vehicle that backs up in order to pass overtakes.
    """
    if plan.replan_route and not any(behavior.outranks_replan for behavior in plan.behaviors):
        return Solution(intent=GuidanceIntent.REROUTE)
    ranked = [(b.solution_rank, k, b) for k, b in enumerate(plan.behaviors) if b.solution_rank is not None]
    if not ranked:
        return None
    _, _, behavior = min(ranked, key=lambda item: item[:2])
    return Solution(intent=behavior.intents[0], side=behavior.passing_side)
