"""Judges plans and carries them through on what the senses show, and has the witness see it all."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.decision import Directive, RecoveryPlan, releases
from stucksolver.guard import NOBODY, Approvals, Guard, Verdict
from stucksolver.reason.reasoner import PlanCheck
from stucksolver.scene import Reading, Scene, Surroundings
from stucksolver.scene.view import View
from stucksolver.solver.events import Judgement, Tick
from stucksolver.solver.execution import Execution, Outcome
from stucksolver.solver.failures import Failures, passes
from stucksolver.solver.minimal_risk import minimal_risk, stops_where_one_may_stand
from stucksolver.solver.senses import Read, Senses
from stucksolver.solver.telling import Teller
from stucksolver.solver.trial import Need, against_offers, against_releases, missing_yes

BLIND_LIMIT_S = 5.0
"""A running plan ends after so long without anything new seen: it cannot be known any more whether it is done."""


@dataclass(frozen=True)
class Judged:
    """A plan with the guard's verdict, ready to start if that is an acceptance."""

    plan: RecoveryPlan
    verdict: Verdict
    execution: Execution
    view: View
    need: Need | None
    passing: bool
    """Refused only for traffic that will go on?"""


class Running:
    """`offset_s`: what must be taken off the solver's own time to have the stack's."""

    def __init__(self, guard: Guard, teller: Teller) -> None:
        self.guard = guard
        self._teller = teller
        self.senses = Senses()
        self.execution: Execution | None = None
        self.ended: Execution | None = None
        """The last one that came to its end."""
        self.withdrawn = False
        """Was the last plan taken back by words?"""
        self.offset_s = 0.0

    def judge(
        self,
        plan: RecoveryPlan,
        read: Read,
        now_s: float,
        *,
        scene: Scene | None,
        failures: Failures,
        guided: bool,
        approvals: Approvals,
        again: bool = False,
    ) -> Judged | None:
        """Check a plan against the world as it is now; None where nothing is known of it.

        `again`: it is looked at on every tick for its moment; only an acceptance is told.
        """
        seen = self.senses.look(read, now_s)
        if seen is None:
            return None
        view = View(seen)
        execution = Execution(plan, self.guard, guided, approvals)
        known = against_offers(plan, scene) or failures.against(plan)
        verdict = known or against_releases(plan, self.guard, approvals) or execution.start(view, now_s)
        if verdict.accepted or not again:
            self._teller.judgement(
                Judgement(now_s - self.offset_s, now_s, plan, seen, guided, approvals, verdict),
            )
        need = None
        if known is None and not verdict.accepted and not again:
            need = missing_yes(plan, verdict, self.guard, view, now_s, guided, approvals)
        return Judged(plan, verdict, execution, view, need, passes(verdict, moving(view)))

    def second_opinion(self, seen: Surroundings, now_s: float, reading: Reading | None) -> PlanCheck:
        """What the guard would say of a plan, for a reasoner that asks before it commits; off the control loop."""

        def check(plan: RecoveryPlan) -> str:
            guided = releases(reading, plan)
            return str(Execution(plan, self.guard, guided, NOBODY).start(View(seen), now_s))

        return check

    def aside(self, read: Read, now_s: float, *, scene: Scene | None, failures: Failures) -> Judged | None:
        """The way to a better place to stand, judged; None where there is none, or nothing is known."""
        seen = self.senses.look(read, now_s)
        plan = None if seen is None else minimal_risk(self.guard, View(seen), "")
        behaviors = () if plan is None else plan.behaviors[:-1]
        if all(b.stands_still for b in behaviors):
            return None
        way = RecoveryPlan(behaviors=behaviors)
        return self.judge(way, read, now_s, scene=scene, failures=failures, guided=False, approvals=NOBODY)

    def may_stop(self, read: Read, now_s: float) -> bool:
        """Would a stop here end where one may stand? Where nothing is known it must do."""
        seen = self.senses.look(read, now_s)
        return seen is None or stops_where_one_may_stand(self.guard, View(seen))

    def start(self, judged: Judged) -> None:
        self.execution, self.withdrawn = judged.execution, False

    def withdraw(self) -> None:
        """Give the plan up as soon as that is safe."""
        if self.execution is not None:
            self.execution.withdraw()
            self.withdrawn = True

    def tick(self, read: Read, now_s: float, view: View | None = None) -> Directive | Outcome:
        """The running plan at this tick; `view` where it has been looked at already."""
        execution = self.execution
        assert execution is not None
        seen = view.surroundings if view else self.senses.look(read, now_s)
        if seen is None or self.senses.blind_s(now_s) > BLIND_LIMIT_S:
            self._end()
            return Outcome(False, f"nothing has been seen for {BLIND_LIMIT_S:g} s")
        result = execution.tick(view or View(seen), now_s)
        if self._teller.watched:
            verdict = execution.last_verdict
            self._teller.tick(Tick(now_s - self.offset_s, now_s, seen, self.withdrawn, result, verdict))
        if isinstance(result, Outcome):
            self._end()
        return result

    def clear_to_hand_back(self, read: Read, now_s: float) -> bool:
        """May the stack drive on from where a plan was given up? So it must, too, where nothing is seen for long."""
        seen = self.senses.look(read, now_s)
        if seen is None:
            return self.senses.blind_s(now_s) > BLIND_LIMIT_S
        return self.guard.clear_to_hand_back(View(seen))

    def _end(self) -> None:
        self.ended, self.execution = self.execution, None


def moving(view: View) -> frozenset[str]:
    """Ids of what moves now."""
    return frozenset(o.id for o, moves in zip(view.objects, view.moving, strict=True) if moves)
