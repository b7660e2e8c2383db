"""The reasoners there are, and how one is consulted: first the cheap look for a reason to wait, then the question."""

from __future__ import annotations

from collections.abc import Mapping

from stucksolver.decision import Decision, WaitReason
from stucksolver.ladder import Waits
from stucksolver.reason import Reasoner, ReasonerError, RuleReasoner, Traced
from stucksolver.reason.reasoner import AsksGuard, KeepsDeadline, PlanCheck
from stucksolver.scene import Scene
from stucksolver.solver.answer import Answer


class ReasonerPool:
    """Reasoners by the name that the ladder calls them."""

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
        """Ask one about a scene; with `screen`, rules answer in its place where the vehicle is only held up.

        `check` lets it ask the guard first; `limit_s` is the wall time that it has.

        Runs off the control loop. Raises what the reasoner raises, and `ReasonerError` for an answer of the wrong type.
        """
        reasoner = self.reasoners[name]
        if screen and scene.guidance is None and not isinstance(reasoner, RuleReasoner):
            held = self._rules.decide(scene)
            reason = held.analysis.wait
            if self._waits.is_wait(reason) and not held.analysis.immobilized and reason not in outlived:
                return Answer(held, self._rules.name)
        if isinstance(reasoner, AsksGuard):
            reasoner.check_with(check)
        if limit_s is not None and isinstance(reasoner, KeepsDeadline):
            reasoner.answer_within(limit_s)
        decision = reasoner.decide(scene)
        if not isinstance(decision, Decision):
            raise ReasonerError(f"{reasoner.name} answered with a {type(decision).__name__}, not a Decision")
        trace = reasoner.last_trace if isinstance(reasoner, Traced) else None
        return Answer(decision, reasoner.name, trace)
