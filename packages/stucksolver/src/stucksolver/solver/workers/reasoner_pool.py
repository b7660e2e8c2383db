"""The available reasoners, and how one is asked: first a cheap check for a reason to wait, then the question."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from stucksolver.ladder import WaitPolicy
from stucksolver.plan import Decision, WaitReason, apply_limits_to_decision
from stucksolver.reasoners import Reasoner, ReasonerAnswer, ReasonerRequest, ReasonerTrace, RuleReasoner
from stucksolver.reasoners.reasoner import MalformedAnswerError, PlanCheck
from stucksolver.scene import Scene
from stucksolver.scene.bounded_values import MalformedError, read_again

MOST_VALUES = 10_000
"""Values in a decision, or in its trace, at most. A model's observation of 60 objects has 500."""
LONGEST_NAME = 200
"""Characters of a reasoner's name at most."""


class ReasonerPool:
    """Reasoners by the names that the ladder uses."""

    def __init__(self, reasoners: Mapping[str, Reasoner], waits: WaitPolicy) -> None:
        self.reasoners = dict(reasoners)
        # Read once, because a property may raise later.
        self.names = {rung: str(reasoner.name) for rung, reasoner in self.reasoners.items()}
        self._waits = waits
        self._rules = RuleReasoner(waits.limits())

    def consult(
        self,
        name: str,
        scene: Scene,
        *,
        screen: bool,
        outlived: frozenset[WaitReason],
        check: PlanCheck | None = None,
        limit_s: float | None = None,
    ) -> ReasonerAnswer:
        """Ask one reasoner about a scene. Runs outside the control loop.

        Args:
            name: The ladder's name for the reasoner.
            scene: What the reasoner is told.
            screen: Let the rules answer instead if the vehicle is only held up.
            outlived: Reasons to wait that have lasted too long.
            check: Asks the guard about a plan before the reasoner answers.
            limit_s: Wall time for the answer (s).

        Raises:
            ReasonerError: The reasoner failed.
            MalformedAnswerError: Its answer cannot be used.
        """
        reasoner, request = self.reasoners[name], ReasonerRequest(scene, check, limit_s)
        if screen and scene.guidance is None and not isinstance(reasoner, RuleReasoner):
            held = self._rules.decide(request)
            analysis = held.decision.analysis
            if self._waits.is_wait(analysis.wait) and not analysis.immobilized and analysis.wait not in outlived:
                return held
        answer = sound_answer(reasoner.decide(request), self.names[name])
        return replace(answer, decision=apply_limits_to_decision(answer.decision, scene))


def sound_answer(answer: object, name: str) -> ReasonerAnswer:
    """Return a validated copy of what a reasoner answered. The effort is bounded, whatever it is.

    Args:
        answer: The answer.
        name: The reasoner's name.

    Raises:
        MalformedAnswerError: It is not an `ReasonerAnswer` with a `Decision` within all bounds.
    """
    if type(answer) is not ReasonerAnswer:
        raise MalformedAnswerError(f"{name} answered with a {type(answer).__name__}, not an Answer")
    held = object.__getattribute__(answer, "__dict__")
    decision, who, trace = (held.get(field) for field in ("decision", "reasoner", "trace"))
    try:
        if type(who) is not str or len(who) > LONGEST_NAME:
            raise MalformedError("its `reasoner` is not a name")
        read = read_again(decision, Decision, MOST_VALUES)
        return ReasonerAnswer(read, who, None if trace is None else read_again(trace, ReasonerTrace, MOST_VALUES))
    except MalformedError as error:
        raise MalformedAnswerError(f"{name} answered with a decision that cannot be used: {error}") from error
