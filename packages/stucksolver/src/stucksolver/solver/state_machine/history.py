"""The plans that failed in this intervention: reported to the reasoner, and not repeated for the same reason."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from stucksolver.guard import OK, RejectCode, RejectReason, Verdict
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import Behavior
from stucksolver.plan.behaviors.behavior import CREEP_MPS
from stucksolver.scene import AttemptOutcome, FailedAttempt, Scene
from stucksolver.scene.failed_attempts import MissingAmount
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.notices import StandstillReason, binding_reject, verdict_reason
from stucksolver.solver.state_machine.blockers import Blocker

UNSEEN = frozenset({RejectCode.TIMEOUT, RejectCode.DEVIATION})
"""Reasons that cannot be seen before a plan starts: a plan that failed for one of them is not started again."""
PASSING = frozenset(
    {
        RejectCode.ONCOMING_GAP,
        RejectCode.LANE_ENTRY,
        RejectCode.RED_LIGHT,
        RejectCode.STALE,
        RejectCode.WAIT_FIRST,
    }
)
"""Reasons that end when the traffic moves on: waiting is right, and no try is used up."""
ONLY_REPEATED = (RejectCode.REPEATED,)
NEAR = frozenset({RejectCode.COLLISION, RejectCode.CLEARANCE, RejectCode.GAP, RejectCode.NO_ABORT})
"""Reasons that end when their object has moved on."""
TEXTS = {
    AttemptOutcome.DECLINED: "a person said no",
    AttemptOutcome.ABORTED: "its next step was refused after the first one was done",
    AttemptOutcome.INEFFECTIVE: "it was done, and the vehicle did not get on",
}
ALIKE = 0.5
"""Two plans whose distances (m) and speeds (m/s) differ by less than this are the same plan."""
GOT_ON_M = 1.0
"""A finished plan with less new progress than this changed nothing."""

Signature = tuple[tuple[str, ...], ...]


def signature(plan: RecoveryPlan) -> Signature:
    """The key by which two plans count as the same: their behaviors and what they refer to, without the numbers.

    Walking pace makes a different plan: a plan that was too fast or too near may be tried again at walking pace.
    """
    return tuple((b.name, *_words(b), *_pace(b)) for b in plan.behaviors)


def _words(behavior: Behavior) -> tuple[str, ...]:
    figures = behavior.model_dump(mode="json")
    return tuple(f"{k}={v}" for k, v in sorted(figures.items()) if not isinstance(v, float))


def _pace(behavior: Behavior) -> tuple[str, ...]:
    speed = getattr(behavior, "speed_mps", None)
    return () if speed is None else ("walking" if speed <= CREEP_MPS else "driving",)


def _alike(first: RecoveryPlan, second: RecoveryPlan) -> bool:
    """True for the same behaviors with numbers that hardly differ."""
    if signature(first) != signature(second):
        return False
    pairs = zip(map(_figures, first.behaviors), map(_figures, second.behaviors), strict=True)
    return all(abs(a - b) < ALIKE for ones, others in pairs for a, b in zip(ones, others, strict=True))


def _figures(behavior: Behavior) -> list[float]:
    return [value for _, value in sorted(behavior.model_dump().items()) if isinstance(value, float)]


def missing_amounts(verdict: Verdict) -> tuple[MissingAmount, ...]:
    """Return what a plan lacks, for the reject reasons of a verdict that have an amount."""
    return tuple(
        MissingAmount(code=reject.code, amount=reject.missing, unit=reject.unit)
        for reject in verdict.rejects
        if reject.missing is not None and reject.unit is not None
    )


@dataclass(frozen=True)
class AttemptHistory:
    """The failed plans of one intervention. `remembered` is the number of attempts reported to the reasoner."""

    remembered: int
    barred: Mapping[Signature, str] = field(default_factory=lambda: MappingProxyType({}))
    """Plans that are not begun again, with the reason."""
    attempts: tuple[FailedAttempt, ...] = ()
    halves: tuple[RecoveryPlan, ...] = ()
    """Plans that ended because a later step was refused."""
    reason: StandstillReason | None = None
    """The reason of the last attempt that was no mere repetition of an earlier one."""
    blocker: Blocker | None = None
    """The object that all of this is about; set if the intervention ended only because that object moved on."""

    def with_attempt(
        self, plan: RecoveryPlan, ended: AttemptOutcome, time_s: float, *, text: str = "", verdict: Verdict = OK
    ) -> AttemptHistory:
        """Add an attempt to those reported to the reasoner.

        Args:
            plan: The plan that did not work.
            ended: How it ended.
            time_s: When it ended (s).
            text: A reason beyond the verdict.
            verdict: Why it was refused or given up.
        """
        attempt = FailedAttempt(
            time_s=time_s,
            behaviors=tuple(b.name for b in plan.behaviors),
            ended=ended,
            codes=verdict.codes,
            failures=verdict.failures,
            too_near=verdict.too_near,
            plan=tuple(b.model_dump_json() for b in plan.behaviors),
            blocker=None if (reject := binding_reject(verdict)) is None else reject.object_id,
            missing=missing_amounts(verdict),
            outcome=text or TEXTS.get(ended) or str(verdict),
        )
        # A repetition says nothing new, and must not push out the attempts that have the reasons.
        kept = (a for a in self.attempts if a.codes != ONLY_REPEATED or a.behaviors != attempt.behaviors)
        attempts = (*kept, attempt)[-self.remembered :] if self.remembered else ()
        reason = verdict_reason(verdict, None)
        if reason is None and verdict.accepted:
            reason = StandstillReason(text=attempt.outcome)
        return replace(self, attempts=attempts, reason=reason or self.reason)

    def about(self, scene: Scene, progress_m: float, within_m: float) -> AttemptHistory:
        """Return the history for a new intervention: kept only if the same object still blocks the path.

        Args:
            scene: The scene of the query.
            progress_m: Progress on the route (m).
            within_m: Gap beyond which the object counts as gone (m).
        """
        kept = self.blocker is None or self.blocker.still_blocks(scene, progress_m, within_m)
        return self if kept else AttemptHistory(self.remembered)

    def aborted(self, plan: RecoveryPlan, verdict: Verdict) -> AttemptHistory:
        """A running plan was given up: bar it if the reason cannot be seen before it starts."""
        codes = sorted({r.code.value for r in verdict.rejects if r.code in UNSEEN})
        return self._barred(plan, ", ".join(codes)) if codes else self

    def half_done(self, plan: RecoveryPlan, *, for_traffic: bool = False) -> AttemptHistory:
        """A later step of the plan was refused. The same plan would end there again; another one of its kind may not.

        A second plan of the kind is the last one, unless only traffic prevented the step (`for_traffic`).
        """
        kept = replace(self, halves=(*self.halves, plan))
        if for_traffic:
            return kept
        again = any(signature(halve) == signature(plan) for halve in self.halves)
        return kept._barred(plan, TEXTS[AttemptOutcome.ABORTED]) if again else kept

    def useless(self, plan: RecoveryPlan) -> AttemptHistory:
        """The plan finished and changed nothing."""
        return self._barred(plan, TEXTS[AttemptOutcome.INEFFECTIVE])

    @staticmethod
    def may_be_useless(plan: RecoveryPlan) -> bool:
        """True if the plan should have moved the vehicle on. Moves that only prepare the next step do not count."""
        return not all(b.prepares for b in plan.behaviors)

    def denied(self, plan: RecoveryPlan) -> AttemptHistory:
        """A person denied the plan."""
        return self._barred(plan, TEXTS[AttemptOutcome.DECLINED])

    def against(self, plan: RecoveryPlan) -> Verdict | None:
        """Refuse a plan that failed before, if the reason still holds."""
        why = self.barred.get(signature(plan))
        if why is None and any(_alike(halve, plan) for halve in self.halves):
            why = TEXTS[AttemptOutcome.ABORTED]
        if why is None:
            return None
        detail = f"the same plan failed before: {why}"
        return Verdict(rejects=(RejectReason(code=RejectCode.REPEATED, detail=detail),))

    def without_attempts(self) -> AttemptHistory:
        """Forget the attempts, because new words ask for something new; barred plans stay barred."""
        return replace(self, attempts=())

    def _barred(self, plan: RecoveryPlan, why: str) -> AttemptHistory:
        return replace(self, barred=MappingProxyType({**self.barred, signature(plan): why}))


def moving(view: FrenetScene) -> frozenset[str]:
    """Ids of the objects that are moving now."""
    return frozenset(o.id for o, moves in zip(view.objects, view.moving, strict=True) if moves)


def passes(verdict: Verdict, moving: frozenset[str], *, sensed: bool = False) -> bool:
    """True if a plan is refused only because of traffic that will move on.

    Args:
        verdict: The refusal.
        moving: Ids of the moving objects.
        sensed: The vehicle sees by its sensors. Then a car that comes hides the oncoming lane behind it.
    """
    traffic = [r.code in PASSING or (r.code in NEAR and r.object_id in moving) for r in verdict.rejects]
    # What is hidden beside traffic is mostly hidden by that traffic, and is seen once it has moved on.
    unseen = (RejectCode.PATH_NOT_VISIBLE, RejectCode.ONCOMING_SIGHT) if sensed else (RejectCode.PATH_NOT_VISIBLE,)
    hidden = [r.code in unseen for r in verdict.rejects]
    return any(traffic) and all(item or other for item, other in zip(traffic, hidden, strict=True))


def waits_for_nothing(verdict: Verdict, moving: frozenset[str]) -> bool:
    """True if no reason of a refusal ends by waiting: no object moves, and neither traffic nor sight lacks.

    Args:
        verdict: The refusal.
        moving: Ids of the moving objects.
    """
    ends = PASSING | {RejectCode.PATH_NOT_VISIBLE, RejectCode.ONCOMING_SIGHT}
    return not any(r.code in ends or r.object_id in moving for r in verdict.rejects)
