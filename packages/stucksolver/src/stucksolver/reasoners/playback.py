"""`teacher:DIR`: plays back the best plan that a search has found for a standstill, and waits at all others.

The rules look first, so that their observation and their reasons to wait stand in each answer. Only the plan is
replaced, and only for a scene that is in the book.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError

from stucksolver.plan import Decision, RecoveryPlan, WaitReason
from stucksolver.reasoners.reasoner import ReasonerAnswer, ReasonerRequest, ReasonerTrace
from stucksolver.reasoners.registry import ReasonerKind, ReasonerNameError, register
from stucksolver.reasoners.rules import RuleReasoner
from stucksolver.scene import Scene
from stucksolver.scene.base_model import FrozenModel

BOOK = "best.json"
DIGITS = 16
"""Length of a digest: 64 bits tell any number of standstills apart that can be driven."""
Elsewhere = Literal["wait", "rules"]


class PlanTable(FrozenModel):
    """The plans to play back, by `scene_digest`. None: at this standstill waiting was best."""

    version: Literal[1] = 1
    plans: dict[str, RecoveryPlan | None] = Field(default_factory=dict)


def scene_digest(scene: Scene) -> str:
    """Return a short digest of everything in a scene but the camera's image."""
    return hashlib.sha256(scene.model_dump_json(exclude={"image"}).encode()).hexdigest()[:DIGITS]


class PlaybackReasoner:
    """Answers the scenes of a book with its plans.

    Args:
        book: The plans.
        elsewhere: What to do in any other scene: wait whatever the rules propose, or what the rules propose.
    """

    def __init__(self, book: PlanTable, elsewhere: Elsewhere = "wait") -> None:
        self.name = "teacher" if elsewhere == "wait" else "teacher-then-rules"
        self._book = book
        self._elsewhere = elsewhere
        self._rules = RuleReasoner()
        self._apart = False
        """True once the drive differs from that of the rules."""

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return the plan of the book for this very scene, or what is done elsewhere; in the same drive the same."""
        said = self._rules.decide(request).decision
        digest = scene_digest(request.scene)
        plan = self._book.plans.get(digest)
        if plan is not None:
            said, self._apart = _played(said, plan), True
        elif self._elsewhere == "wait" or digest in self._book.plans:
            # As long as the rules wait as well, the wait is theirs: the ladder then looks again when it would with
            # them, and the standstills of the book are met at the same ticks.
            self._apart = self._apart or said.plan is not None or digest in self._book.plans
            said = waiting(said) if self._apart else said
        return ReasonerAnswer(said, self.name, ReasonerTrace(answers=(said.model_dump_json(),), model=self.name))


def waiting(decision: Decision) -> Decision:
    """Return the decision as a wait, without its plan.

    It counts as a queue, for which every ladder waits longest: so the driver keeps driving by itself, and no rung above
    is reached meanwhile.
    """
    waits = {"immobilized": False, "cause": None, "wait": WaitReason.QUEUE}
    analysis = decision.analysis.model_copy(update=waits)
    return decision.model_copy(update={"analysis": analysis, "plan": None, "rationale": "wait"})


def _played(decision: Decision, plan: RecoveryPlan) -> Decision:
    stuck = decision.analysis.model_copy(update={"immobilized": True, "wait": None})
    names = ", ".join(behavior.name for behavior in plan.behaviors)
    return decision.model_copy(update={"analysis": stuck, "plan": plan, "rationale": f"played back: {names}"})


def read_book(folder: Path) -> PlanTable:
    """Read the book of a folder that `python -m lab distill collect` filled.

    Raises:
        ReasonerNameError: There is none, or it cannot be read.
    """
    path = folder / BOOK
    try:
        return PlanTable.model_validate_json(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ReasonerNameError(
            f"no plans in {folder}: {error}; `python -m lab distill collect` writes {BOOK}"
        ) from error
    except ValidationError as error:
        raise ReasonerNameError(f"{path} is not a book of plans: {error.errors()[0]['msg']}") from error


def _teacher(rest: str, exchanges: Path | None) -> PlaybackReasoner:
    return PlaybackReasoner(read_book(Path(rest)))


def _teacher_then_rules(rest: str, exchanges: Path | None) -> PlaybackReasoner:
    return PlaybackReasoner(read_book(Path(rest)), elsewhere="rules")


register(ReasonerKind("teacher", "teacher:DIR", _teacher))
register(ReasonerKind("teacher-then-rules", "teacher-then-rules:DIR", _teacher_then_rules))
