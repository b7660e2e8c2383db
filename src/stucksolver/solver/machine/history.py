"""What has failed in this intervention: told to the reasoner, and not repeated for the same reason."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from stucksolver.decision import RecoveryPlan
from stucksolver.decision.behaviors import Behavior
from stucksolver.decision.behaviors.base import CREEP_MPS
from stucksolver.guard import OK, Reject, RejectCode, Verdict
from stucksolver.scene import AttemptEnd, PastAttempt

UNSEEN = frozenset({RejectCode.TIMEOUT, RejectCode.DEVIATION})
"""Reasons that no look at the start of a plan can find: a plan that failed for them is not started again."""
PASSING = frozenset(
    {
        RejectCode.ONCOMING_GAP,
        RejectCode.LANE_ENTRY,
        RejectCode.RED_LIGHT,
        RejectCode.STALE,
        RejectCode.WAIT_FIRST,
    }
)
"""Reasons that go away with the traffic: waiting is right, and no try is used up."""
TEXTS = {
    AttemptEnd.DENIED: "a person said no",
    AttemptEnd.USELESS: "it was done, and the vehicle did not get on",
}
GOT_ON_M = 1.0
"""With less new progress than this a finished plan changed nothing."""

Signature = tuple[tuple[str, ...], ...]


def signature(plan: RecoveryPlan) -> Signature:
    """What makes two plans the same: their behaviours with what they refer to, whatever the figures.

    Walking pace alone makes another plan: what was given up for being too quick or too near may be tried again so.
    """
    return tuple((b.name, *_words(b), *_pace(b)) for b in plan.behaviors)


def _words(behavior: Behavior) -> tuple[str, ...]:
    figures = behavior.model_dump(mode="json")
    return tuple(f"{k}={v}" for k, v in sorted(figures.items()) if not isinstance(v, float))


def _pace(behavior: Behavior) -> tuple[str, ...]:
    speed = getattr(behavior, "speed_mps", None)
    return () if speed is None else ("walking" if speed <= CREEP_MPS else "driving",)


@dataclass(frozen=True)
class History:
    """Kept from the start of an intervention to its end. `remembered`: so many attempts are told to the reasoner."""

    remembered: int
    barred: Mapping[Signature, str] = field(default_factory=lambda: MappingProxyType({}))
    """Plans that are not begun again, and why."""
    attempts: tuple[PastAttempt, ...] = ()

    def noted(
        self, plan: RecoveryPlan, ended: AttemptEnd, time_s: float, *, text: str = "", verdict: Verdict = OK
    ) -> History:
        """With one more for the reasoner.

        `verdict`: for what it was refused or given up; `text`: where that is not all.
        """
        attempt = PastAttempt(
            time_s=time_s,
            behaviors=tuple(b.name for b in plan.behaviors),
            ended=ended,
            codes=verdict.codes,
            failures=verdict.failures,
            outcome=text or TEXTS.get(ended) or str(verdict),
        )
        return replace(self, attempts=(*self.attempts, attempt)[-self.remembered :] if self.remembered else ())

    def aborted(self, plan: RecoveryPlan, verdict: Verdict) -> History:
        """A running plan was given up: bar it, where the reason cannot be seen before it starts again."""
        codes = sorted({r.code.value for r in verdict.rejects if r.code in UNSEEN})
        return self._barred(plan, ", ".join(codes)) if codes else self

    def useless(self, plan: RecoveryPlan) -> History:
        """It was carried through, and changed nothing."""
        return self._barred(plan, TEXTS[AttemptEnd.USELESS])

    @staticmethod
    def may_be_useless(plan: RecoveryPlan) -> bool:
        """Should the vehicle have got on by it? Not by moves that only prepare what comes next."""
        return not all(b.prepares for b in plan.behaviors)

    def denied(self, plan: RecoveryPlan) -> History:
        """A person said no to it."""
        return self._barred(plan, TEXTS[AttemptEnd.DENIED])

    def against(self, plan: RecoveryPlan) -> Verdict | None:
        """Refuses a plan that has failed before for a reason that has not gone away."""
        why = self.barred.get(signature(plan))
        if why is None:
            return None
        detail = f"the same plan failed before: {why}"
        return Verdict(rejects=(Reject(code=RejectCode.REPEATED, detail=detail),))

    def without_attempts(self) -> History:
        """New words ask for something new; what is barred stays barred."""
        return replace(self, attempts=())

    def _barred(self, plan: RecoveryPlan, why: str) -> History:
        return replace(self, barred=MappingProxyType({**self.barred, signature(plan): why}))


def passes(verdict: Verdict, moving: frozenset[str]) -> bool:
    """Is everything that speaks against a plan traffic that will go on? `moving`: ids of what moves now."""
    near = (RejectCode.COLLISION, RejectCode.CLEARANCE, RejectCode.GAP, RejectCode.NO_ABORT)
    traffic = [r.code in PASSING or (r.code in near and r.object_id in moving) for r in verdict.rejects]
    # What cannot be seen beside traffic is mostly hidden by it: it shows when that has gone on.
    hidden = [r.code is RejectCode.UNSEEN for r in verdict.rejects]
    return any(traffic) and all(one or other for one, other in zip(traffic, hidden, strict=True))
