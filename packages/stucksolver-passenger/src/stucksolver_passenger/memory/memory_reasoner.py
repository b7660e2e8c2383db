"""A reasoner that first proposes a solution that worked in similar scenes, and otherwise queries another reasoner."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from stucksolver.plan import Decision, RecoveryPlan, WaitLimits, WaitReason
from stucksolver.reasoners import Reasoner, ReasonerAnswer, ReasonerRequest, ReasonerTrace, SearchReasoner
from stucksolver.reasoners.reasoner import Cancellable, SupportsPreflight
from stucksolver.scene import Guidance, Interpretation, Scene
from stucksolver_passenger.memory.features import LaneState, SceneFeatures, features_of
from stucksolver_passenger.memory.recall import RecalledSolution, recall
from stucksolver_passenger.memory.solution import solution_of
from stucksolver_passenger.memory.tried_solution import TriedSolution

NAME = "memory"
"""Name of the reasoner in answers from the memory."""
Episodes = Callable[[SceneFeatures], tuple[TriedSolution, ...]]
"""Returns the entries with the same obstacle; none if the memory cannot be read."""


class MemoryReasoner:
    """Wraps another reasoner on the same rung of the ladder.

    It has no plan of its own. It searches a plan for a stored solution in this scene, and proposes that. So the numbers
    are those of this scene, and impossible solutions are not proposed. It answers only if the vehicle is immobilized
    without a reason to wait, and if the solution has not failed in this intervention.

    Its proposals count as proposals of the vehicle. The guard checks them without the permission that guidance would
    give, and the approvals that the ladder requires apply again.
    """

    def __init__(self, inner: Reasoner, episodes: Episodes, limits: WaitLimits | None = None) -> None:
        self._inner = inner
        self._episodes = episodes
        self._search = SearchReasoner(limits)

    @property
    def name(self) -> str:
        """Name of the other reasoner, with the memory before it."""
        return f"{NAME}, then {self._inner.name}"

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return a solution that worked before, or the other reasoner's answer.

        Raises:
            ReasonerError: The other reasoner has no answer.
        """
        proposed = self._proposed(request)
        return self._inner.decide(request) if proposed is None else proposed

    def cancel(self) -> None:
        """Cancel the other reasoner's query, if it supports that."""
        if isinstance(self._inner, Cancellable):
            self._inner.cancel()

    def preflight(self) -> tuple[str, ...]:
        """Return the other reasoner's notes.

        Raises:
            ReasonerError: The other reasoner would fail.
        """
        return self._inner.preflight() if isinstance(self._inner, SupportsPreflight) else ()

    # ---- solutions that worked before

    def _proposed(self, request: ReasonerRequest) -> ReasonerAnswer | None:
        scene = request.scene
        base = self._search.decide(request).decision
        features = features_of(scene)
        if not base.analysis.immobilized or _is_wait(base.analysis.wait, features):
            return None  # waiting is right, or there is nothing to do
        reading = None if scene.guidance is None else scene.guidance.reading
        found = recall(self._episodes(features), features, reading)
        for item in found:
            if not item.trusted:
                return None
            if base.plan is not None and solution_of(base.plan) == item.solution:
                return None  # the search finds it without the memory
            plan = self._plan_for(request, item)
            if plan is not None and not _was_tried(scene, plan):
                return _answer(base, item, plan)
        return None

    def _plan_for(self, request: ReasonerRequest, solution: RecalledSolution) -> RecoveryPlan | None:
        """Return the plan for a solution in this scene; None if the solution is impossible here."""
        asked = Interpretation(
            intent=solution.solution.intent,
            side=solution.solution.side,
            confidence=solution.rate.mean,
            likely=solution.solution.intent,
            reader=NAME,
        )
        guidance = Guidance(text="", time_s=request.scene.time_s, reading=asked)
        scene = request.scene.model_copy(update={"guidance": guidance})
        plan = self._search.decide(replace(request, scene=scene)).decision.plan
        return plan if plan is not None and solution_of(plan) == solution.solution else None


def _is_wait(reason: WaitReason | None, features: SceneFeatures) -> bool:
    """True if waiting helps. No road user has to yield to a static object in the oncoming lane."""
    lasting = reason is WaitReason.YIELD and features.oncoming is LaneState.BLOCKED
    return reason not in (None, WaitReason.NO_SAFE_WAY) and not lasting


def _was_tried(scene: Scene, plan: RecoveryPlan) -> bool:
    """True if the same solution was tried in this intervention, with any numbers."""
    names = tuple(b.name for b in plan.behaviors)
    return any(attempt.behaviors == names for attempt in scene.attempts)


def _answer(base: Decision, solution: RecalledSolution, plan: RecoveryPlan) -> ReasonerAnswer:
    rate = solution.rate
    why = f"memory: {solution.solution.name} worked {rate.worked} of {rate.tries} times in scenes like this one"
    analysis = base.analysis.model_copy(update={"wait": None})
    decision = base.model_copy(update={"analysis": analysis, "plan": plan, "rationale": why})
    # The decision is its own trace, so a record of it can be replayed without the memory.
    return ReasonerAnswer(decision, NAME, ReasonerTrace(answers=(decision.model_dump_json(),)))
