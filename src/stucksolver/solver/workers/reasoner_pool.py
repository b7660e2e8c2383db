"""The available reasoners, and how one is asked: first a cheap check for a reason to wait, then the question."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from stucksolver.decision import Decision, WaitReason, decided_as_said
from stucksolver.ladder import Waits
from stucksolver.reason import Answer, Reasoner, ReasonerError, Request, RuleReasoner
from stucksolver.reason.reasoner import PlanCheck
from stucksolver.scene import Scene


class ReasonerPool:
    """Reasoners by the names that the ladder uses."""

    def __init__(self, reasoners: Mapping[str, Reasoner], waits: Waits) -> None:
        self.reasoners = dict(reasoners)
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
    ) -> Answer:
        """Ask one reasoner about a scene. Runs outside the control loop.

        Args:
            name: The ladder's name for the reasoner.
            scene: What the reasoner is told.
            screen: Let the rules answer instead if the vehicle is only held up.
            outlived: Reasons to wait that have lasted too long.
            check: Asks the guard about a plan before the reasoner answers.
            limit_s: Wall time for the answer (s).

        Raises:
            ReasonerError: The reasoner failed or returned the wrong type.
        """
        reasoner, request = self.reasoners[name], Request(scene, check, limit_s)
        if screen and scene.guidance is None and not isinstance(reasoner, RuleReasoner):
            held = self._rules.decide(request)
            analysis = held.decision.analysis
            if self._waits.is_wait(analysis.wait) and not analysis.immobilized and analysis.wait not in outlived:
                return held
        answer = reasoner.decide(request)
        if not isinstance(answer, Answer):
            raise ReasonerError(f"{reasoner.name} answered with a {type(answer).__name__}, not an Answer")
        if not isinstance(answer.decision, Decision):
            raise ReasonerError(f"{reasoner.name} answered with a {type(answer.decision).__name__}, not a Decision")
        return replace(answer, decision=decided_as_said(answer.decision, scene))
