"""A reasoner that proposes first what has worked in scenes like this one, and otherwise asks another."""

from __future__ import annotations

from collections.abc import Callable

from stucksolver.decision import Decision, RecoveryPlan, WaitLimits, WaitReason
from stucksolver.memory.episode import Episode
from stucksolver.memory.features import LaneState, SceneFeatures, features_of
from stucksolver.memory.recall import Remembered, recall
from stucksolver.memory.solution import solution_of
from stucksolver.reason import Answer, Reasoner, Request, RuleReasoner, Trace
from stucksolver.reason.reasoner import Cancellable, Preflighted
from stucksolver.scene import Guidance, Reading, Scene

NAME = "memory"
"""Who answered, where the memory did."""
Episodes = Callable[[SceneFeatures], tuple[Episode, ...]]
"""What is remembered of scenes with the same obstacle; nothing where the memory cannot be read."""


class RememberingReasoner:
    """Stands before another reasoner on the same rung of the ladder.

    It has no plan of its own: it asks the rules what a solution that worked would be here, and proposes that. So the
    figures are those of this scene, and what cannot be done here is not proposed. It speaks only where the rules find
    the vehicle immobilized and no reason to wait, and where the solution has not failed in this intervention.

    What it proposes counts as the vehicle's own idea: it goes through the guard without the leave that a passenger's
    words would give, and a yes that the ladder asks for is asked for again.
    """

    def __init__(self, inner: Reasoner, episodes: Episodes, limits: WaitLimits | None = None) -> None:
        self._inner = inner
        self._episodes = episodes
        self._rules = RuleReasoner(limits)

    @property
    def name(self) -> str:
        """The other reasoner's, with the memory before it."""
        return f"{NAME}, then {self._inner.name}"

    def decide(self, request: Request) -> Answer:
        """What worked before, or what the other reasoner says. Raises what that raises."""
        proposed = self._proposed(request.scene)
        return self._inner.decide(request) if proposed is None else proposed

    def cancel(self) -> None:
        """Tells the other reasoner that its answer is not wanted any more, where it can be told."""
        if isinstance(self._inner, Cancellable):
            self._inner.cancel()

    def preflight(self) -> tuple[str, ...]:
        """The other reasoner's notes. Raises what it raises."""
        return self._inner.preflight() if isinstance(self._inner, Preflighted) else ()

    # ---- what worked before

    def _proposed(self, scene: Scene) -> Answer | None:
        base = self._rules.decide(Request(scene)).decision
        features = features_of(scene)
        if not base.analysis.immobilized or _is_wait(base.analysis.wait, features):
            return None  # waiting is right, or there is nothing to do
        reading = None if scene.guidance is None else scene.guidance.reading
        found = recall(self._episodes(features), features, reading)
        for one in found:
            if not one.trusted:
                return None
            if base.plan is not None and solution_of(base.plan) == one.solution:
                return None  # the rules think of it themselves
            plan = self._plan_for(scene, one)
            if plan is not None and not _was_tried(scene, plan):
                return _answer(base, one, plan)
        return None

    def _plan_for(self, scene: Scene, one: Remembered) -> RecoveryPlan | None:
        """What the rules make of a solution in this scene; None where it cannot be done here."""
        asked = Reading(
            intent=one.solution.intent,
            side=one.solution.side,
            confidence=one.rate.mean,
            likely=one.solution.intent,
            reader=NAME,
        )
        guidance = Guidance(text="", time_s=scene.time_s, reading=asked)
        plan = self._rules.decide(Request(scene.model_copy(update={"guidance": guidance}))).decision.plan
        return plan if plan is not None and solution_of(plan) == one.solution else None


def _is_wait(reason: WaitReason | None, features: SceneFeatures) -> bool:
    """Does waiting help? Nobody need yield to what lies in the oncoming lane and will not go on."""
    lasting = reason is WaitReason.YIELD and features.oncoming is LaneState.BLOCKED
    return reason not in (None, WaitReason.NO_SAFE_WAY) and not lasting


def _was_tried(scene: Scene, plan: RecoveryPlan) -> bool:
    """Has the same been tried in this intervention, with whatever figures?"""
    names = tuple(b.name for b in plan.behaviors)
    return any(attempt.behaviors == names for attempt in scene.attempts)


def _answer(base: Decision, one: Remembered, plan: RecoveryPlan) -> Answer:
    why = f"memory: {one.solution.name} worked {one.rate.worked} of {one.rate.tries} times in scenes like this one"
    analysis = base.analysis.model_copy(update={"wait": None})
    decision = base.model_copy(update={"analysis": analysis, "plan": plan, "rationale": why})
    # With the decision itself as its trace, a record of it can be replayed without the memory.
    return Answer(decision, NAME, Trace(answers=(decision.model_dump_json(),)))
