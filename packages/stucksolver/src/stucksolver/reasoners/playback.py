"""Plays back plans as `teacher:DIR`: the best plan that a search has found for a standstill, else a wait.

The rules are queried first, so that each answer has their observation and their reasons to wait. Only the plan is
replaced, and only for a scene that is in the table.
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
"""Name of the file with the table."""
DIGITS = 16
"""Length of a digest: 64 bits distinguish any number of standstills that can be driven."""
Elsewhere = Literal["wait", "rules"]
"""Answer to a scene that is not in the table."""


class PlanTable(FrozenModel):
    """Plans to play back, by `scene_digest`. None: waiting was best at this standstill."""

    version: Literal[1] = 1
    plans: dict[str, RecoveryPlan | None] = Field(default_factory=dict)


def scene_digest(scene: Scene) -> str:
    """Return a short digest of a scene without the camera's image."""
    return hashlib.sha256(scene.model_dump_json(exclude={"image"}).encode()).hexdigest()[:DIGITS]


class PlaybackReasoner:
    """Reasoner that answers the scenes of a table with its plans.

    Args:
        book: Table of plans.
        elsewhere: Answer to any other scene: a wait regardless of the rules, or the answer of the rules.
    """

    def __init__(self, book: PlanTable, elsewhere: Elsewhere = "wait") -> None:
        self.name = "teacher" if elsewhere == "wait" else "teacher-then-rules"
        self._book = book
        self._elsewhere = elsewhere
        self._rules = RuleReasoner()
        self._apart = False
        """True after the run has diverged from that of the rules."""

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return the plan of the table for this scene, or the answer for other scenes. It is deterministic."""
        decision = self._rules.decide(request).decision
        digest = scene_digest(request.scene)
        plan = self._book.plans.get(digest)
        if plan is not None:
            decision, self._apart = _played(decision, plan), True
        elif self._elsewhere == "wait" or digest in self._book.plans:
            # While the rules wait as well, the wait is theirs. The ladder then checks again at the same ticks as with
            # the rules, and the run reaches the standstills of the table at the same ticks.
            self._apart = self._apart or decision.plan is not None or digest in self._book.plans
            decision = waiting(decision) if self._apart else decision
        trace = ReasonerTrace(answers=(decision.model_dump_json(),), model=self.name)
        return ReasonerAnswer(decision, self.name, trace)


def waiting(decision: Decision) -> Decision:
    """Return the decision as a wait, without its plan.

    It counts as a queue, for which every ladder waits longest. So the driver keeps driving by itself, and no rung above
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
    """Read the table in a folder that `python -m lab distill collect` filled.

    Raises:
        ReasonerNameError: The table does not exist, or cannot be read.
    """
    path = folder / BOOK
    try:
        return PlanTable.model_validate_json(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ReasonerNameError(
            f"no plans in {folder}: {error}; `python -m lab distill collect` writes {BOOK}"
        ) from error
    except ValidationError as error:
        raise ReasonerNameError(f"{path} is not a table of plans: {error.errors()[0]['msg']}") from error


def _teacher(rest: str, exchanges: Path | None) -> PlaybackReasoner:
    return PlaybackReasoner(read_book(Path(rest)))


def _teacher_then_rules(rest: str, exchanges: Path | None) -> PlaybackReasoner:
    return PlaybackReasoner(read_book(Path(rest)), elsewhere="rules")


register(ReasonerKind("teacher", "teacher:DIR", _teacher))
register(ReasonerKind("teacher-then-rules", "teacher-then-rules:DIR", _teacher_then_rules))
