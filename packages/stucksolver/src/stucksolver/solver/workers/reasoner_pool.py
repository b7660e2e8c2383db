"""Available reasoners, and the query to one: first a cheap check for a legitimate wait, then the query."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from stucksolver.ladder import WaitPolicy
from stucksolver.plan import Decision, WaitReason, apply_limits_to_decision
from stucksolver.plan.assessment import PlanAssessor
from stucksolver.query_budget import QueryBudget
from stucksolver.reasoners import Reasoner, ReasonerAnswer, ReasonerRequest, ReasonerTrace, SearchReasoner
from stucksolver.reasoners.duties import NAME as DUTIES
from stucksolver.reasoners.duties import decide_wait
from stucksolver.reasoners.reasoner import MalformedAnswerError, PlanCheck
from stucksolver.scene import Scene
from stucksolver.scene.bounded_values import MalformedError, read_again

MOST_VALUES = 10_000
"""Maximum number of values in a decision, or in its trace. A model's observation of 60 objects has 500. Ours."""
LONGEST_NAME = 200
"""Longest name of a reasoner (characters). Ours."""


class ReasonerPool:
    """Reasoners by the names that the ladder uses."""

    def __init__(self, reasoners: Mapping[str, Reasoner], waits: WaitPolicy) -> None:
        self.reasoners = dict(reasoners)
        # The names are read once, because a property may raise later.
        self.names = {rung: str(reasoner.name) for rung, reasoner in self.reasoners.items()}
        self._waits = waits

    def consult(
        self,
        name: str,
        scene: Scene,
        *,
        screen: bool,
        outlived: frozenset[WaitReason],
        check: PlanCheck | None = None,
        limit_s: float | None = None,
        assess: PlanAssessor | None = None,
        budget: QueryBudget | None = None,
    ) -> ReasonerAnswer:
        """Query one reasoner for a scene. Runs outside the control loop.

        Args:
            name: Name of the reasoner in the ladder.
            scene: Scene as sent to the reasoner.
            screen: True if no reasoner is queried when the vehicle has a legitimate wait.
            outlived: Reasons to wait that have exceeded their limit.
            check: Check of a plan by the guard before the reasoner answers.
            limit_s: Wall time for the answer (s).
            assess: Assessment of a whole plan by the guard before the reasoner answers.
            budget: Bounds of the rung on the use of the reasoner.

        Raises:
            ReasonerError: The reasoner failed.
            MalformedAnswerError: Its answer is unusable.
        """
        reasoner, request = self.reasoners[name], ReasonerRequest(scene, check, limit_s, assess, budget)
        if screen and scene.guidance is None and not isinstance(reasoner, SearchReasoner):
            wait = decide_wait(scene, self._waits.limits())
            analysis = wait.analysis
            if self._waits.is_wait(analysis.wait) and not analysis.immobilized and analysis.wait not in outlived:
                return ReasonerAnswer(wait, DUTIES)
        answer = sound_answer(reasoner.decide(request), self.names[name])
        return replace(answer, decision=apply_limits_to_decision(answer.decision, scene))


def sound_answer(answer: object, name: str) -> ReasonerAnswer:
    """Return a validated copy of a reasoner's answer. The effort is bounded for any answer.

    Args:
        answer: Answer of the reasoner.
        name: Name of the reasoner.

    Raises:
        MalformedAnswerError: The answer is not a `ReasonerAnswer` with a `Decision` within all bounds.
    """
    if type(answer) is not ReasonerAnswer:
        raise MalformedAnswerError(f"{name} answered with a {type(answer).__name__}, expected a ReasonerAnswer")
    fields = object.__getattribute__(answer, "__dict__")
    decision, reasoner, trace = (fields.get(field) for field in ("decision", "reasoner", "trace"))
    try:
        if type(reasoner) is not str or len(reasoner) > LONGEST_NAME:
            raise MalformedError("its `reasoner` is not a name")
        copy = read_again(decision, Decision, MOST_VALUES)
        return ReasonerAnswer(copy, reasoner, None if trace is None else read_again(trace, ReasonerTrace, MOST_VALUES))
    except MalformedError as error:
        raise MalformedAnswerError(f"{name} answered with an unusable decision: {error}") from error
