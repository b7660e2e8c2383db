"""A reasoner that first proposes what has worked in similar scenes, and otherwise asks another one."""

from __future__ import annotations

from collections.abc import Callable

from stucksolver.plan import Decision, RecoveryPlan, WaitLimits, WaitReason
from stucksolver.reasoners import Reasoner, ReasonerAnswer, ReasonerRequest, ReasonerTrace, RuleReasoner
from stucksolver.reasoners.reasoner import Cancellable, SupportsPreflight
from stucksolver.scene import Guidance, Interpretation, Scene
from stucksolver_passenger.memory.features import LaneState, SceneFeatures, features_of
from stucksolver_passenger.memory.recall import RecalledSolution, recall
from stucksolver_passenger.memory.solution import solution_of
from stucksolver_passenger.memory.tried_solution import TriedSolution

NAME = "memory"
"""The name in answers that come from the memory."""
Episodes = Callable[[SceneFeatures], tuple[TriedSolution, ...]]
"""Returns the episodes with the same obstacle; none if the memory cannot be read."""


class MemoryReasoner:
    """Wraps another reasoner on the same rung of the ladder.

    It has no plan of its own: it asks the rules what a remembered solution would be here, and proposes that. So the
    numbers are those of this scene, and what cannot be done here is not proposed. It answers only if the rules find the
    vehicle immobilized without a reason to wait, and if the solution has not failed in this intervention.

    Its proposals count as the vehicle's own: they pass the guard without the permission that a passenger's words would
    give, and an approval that the ladder requires is asked for again.
    """

    def __init__(self, inner: Reasoner, episodes: Episodes, limits: WaitLimits | None = None) -> None:
        self._inner = inner
        self._episodes = episodes
        self._rules = RuleReasoner(limits)

    @property
    def name(self) -> str:
        """Name of the other reasoner with the memory before it."""
        return f"{NAME}, then {self._inner.name}"

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return what worked before, or the other reasoner's answer.

        Raises:
            ReasonerError: The other reasoner has no answer.
        """
        proposed = self._proposed(request.scene)
        return self._inner.decide(request) if proposed is None else proposed

    def cancel(self) -> None:
        """Tell the other reasoner that its answer is no longer wanted, if it supports that."""
        if isinstance(self._inner, Cancellable):
            self._inner.cancel()

    def preflight(self) -> tuple[str, ...]:
        """Return the other reasoner's notes.

        Raises:
            ReasonerError: The other reasoner would fail.
        """
        return self._inner.preflight() if isinstance(self._inner, SupportsPreflight) else ()

    # ---- what worked before

    def _proposed(self, scene: Scene) -> ReasonerAnswer | None:
        base = self._rules.decide(ReasonerRequest(scene)).decision
        features = features_of(scene)
        if not base.analysis.immobilized or _is_wait(base.analysis.wait, features):
            return None  # waiting is right, or there is nothing to do
        reading = None if scene.guidance is None else scene.guidance.reading
        found = recall(self._episodes(features), features, reading)
        for item in found:
            if not item.trusted:
                return None
            if base.plan is not None and solution_of(base.plan) == item.solution:
                return None  # the rules find it themselves
            plan = self._plan_for(scene, item)
            if plan is not None and not _was_tried(scene, plan):
                return _answer(base, item, plan)
        return None

    def _plan_for(self, scene: Scene, solution: RecalledSolution) -> RecoveryPlan | None:
        """Return the rules' plan for a solution in this scene; None if it cannot be done here."""
        asked = Interpretation(
            intent=solution.solution.intent,
            side=solution.solution.side,
            confidence=solution.rate.mean,
            likely=solution.solution.intent,
            reader=NAME,
        )
        guidance = Guidance(text="", time_s=scene.time_s, reading=asked)
        plan = self._rules.decide(ReasonerRequest(scene.model_copy(update={"guidance": guidance}))).decision.plan
        return plan if plan is not None and solution_of(plan) == solution.solution else None


def _is_wait(reason: WaitReason | None, features: SceneFeatures) -> bool:
    """True if waiting helps. Nobody needs to yield to an object in the oncoming lane that stays there."""
    lasting = reason is WaitReason.YIELD and features.oncoming is LaneState.BLOCKED
    return reason not in (None, WaitReason.NO_SAFE_WAY) and not lasting


def _was_tried(scene: Scene, plan: RecoveryPlan) -> bool:
    """True if the same was tried in this intervention, with any numbers."""
    names = tuple(b.name for b in plan.behaviors)
    return any(attempt.behaviors == names for attempt in scene.attempts)


def _answer(base: Decision, solution: RecalledSolution, plan: RecoveryPlan) -> ReasonerAnswer:
    rate = solution.rate
    why = f"memory: {solution.solution.name} worked {rate.worked} of {rate.tries} times in scenes like this one"
    analysis = base.analysis.model_copy(update={"wait": None})
    decision = base.model_copy(update={"analysis": analysis, "plan": plan, "rationale": why})
    # With the decision itself as its trace, a record of it can be replayed without the memory.
    return ReasonerAnswer(decision, NAME, ReasonerTrace(answers=(decision.model_dump_json(),)))
