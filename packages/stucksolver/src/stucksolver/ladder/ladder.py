"""Escalation policy as data: the rungs, the effort on each, and the required approvals."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator

from stucksolver.guard import GuardPolicy
from stucksolver.ladder.rung_actions import FIRST_REASONER, CallAssistance, CheckForWait
from stucksolver.ladder.rungs import AnyRung
from stucksolver.ladder.waits import NEVER_LONG, WaitPolicy
from stucksolver.plan.behaviors import REGISTRY, ApprovalLevel
from stucksolver.scene.base_model import FrozenModel

FORMER_KIND = "rules"
"""Former name of the kind `reasoner` of a rung, and of that reasoner in records."""


class HandBack(FrozenModel):
    """End of an intervention."""

    progress_m: float = Field(default=15.0, gt=0)
    """New progress since the onset that verifies the recovery (m). Only then are the counters reset."""
    gone_m: float = Field(default=30.0, ge=0)
    """Gap beyond which the blocker of the intervention counts as gone (m).

    While it is still in the path and nearer, the same progress only means that the queue has moved: failed plans stay
    in memory. 0: any such progress is a recovery. Ours.
    """


class QuestionTimeouts(FrozenModel):
    """Factors on the longest waits for other vehicles, after a passenger's claim about time."""

    hurry: float = Field(default=0.5, ge=0.25, le=1.0)
    """Factor after "I am late". Ours."""
    no_hurry: float = Field(default=2.0, ge=1.0, le=4.0)
    """Factor after "no hurry". Ours."""


class GuidancePolicy(FrozenModel):
    """Handling of a passenger's guidance."""

    expire_s: float = Field(default=30.0, gt=0)
    """Time after which guidance expires (s). Ours."""
    claims_s: float = Field(default=60.0, gt=0, le=600)
    """Time for which accepted claims about the world count (s). Ours."""
    patience: QuestionTimeouts = QuestionTimeouts()


class QuestionSettings(FrozenModel):
    """Settings common to all questions."""

    recheck_s: float = Field(default=1.0, ge=0.1)
    """Time until the scene is checked again after an answer without a plan and without a wait of its own (s). Ours."""
    approval_within_s: float = Field(default=30.0, gt=0)
    """Time after which a request for a person's approval is withdrawn (s). Ours."""
    hold_s: float = Field(default=8.0, ge=0)
    """Time for which a plan that only traffic prevents is checked on every tick, since a gap may open (s). Ours."""
    next_step_s: float = Field(default=30.0, gt=0, le=600)
    """Time for which a running plan waits for traffic before its next step (s); then it ends. Ours."""
    remembered: int = Field(default=5, ge=0, le=50)
    """Maximum number of failed plans in the scene of a reasoner. Ours."""


class TellSettings(FrozenModel):
    """When people are informed why the vehicle stands still. Nobody has to act on it."""

    passenger_s: float = Field(default=10.0, gt=0, le=NEVER_LONG)
    """Time after the stop by which the passenger is informed (s)."""
    operator_s: float = Field(default=30.0, gt=0, le=NEVER_LONG)
    """Time after the stop by which the operator is informed (s)."""
    light_s: float = Field(default=50.0, gt=0, le=NEVER_LONG)
    """The same for both at a red light (s). Ours: longer than most lights stay red."""


class StandoffSettings(FrozenModel):
    """How a standoff ends in which two vehicles wait for each other."""

    after_s: float = Field(default=8.0, gt=0, le=600)
    """Time after which stopped vehicles that face each other are in a standoff (s); each period has its draw. Ours."""
    back_off_s: float = Field(default=4.0, ge=0, le=60)
    """Longest drawn time until the next query in a standoff (s); 0 for none. Ours."""


class Approval(FrozenModel):
    """Required approvals: `autonomous` (no person), `passenger` or `operator`; for solid lines also `forbid`."""

    solid_line: Literal["forbid", "autonomous", "passenger", "operator"] = "passenger"
    authority: ApprovalLevel = ApprovalLevel.OPERATOR
    """Approval for passing a school bus, level crossing or flagger."""
    emergency_scene: ApprovalLevel = ApprovalLevel.OPERATOR
    """Approval for passing a stopped emergency vehicle. None is required if the ego moves over by a whole lane."""
    behaviors: dict[str, ApprovalLevel] = Field(default_factory=dict)
    """Approvals by the name of a behavior; behaviors that are not listed keep their default."""

    @field_validator("behaviors")
    @classmethod
    def _known(cls, behaviors: dict[str, ApprovalLevel]) -> dict[str, ApprovalLevel]:
        for name in behaviors:
            if name not in REGISTRY:
                raise ValueError(f"unknown behavior {name!r}; choose from: {', '.join(REGISTRY)}")
        return behaviors


class Ladder(FrozenModel):
    """Rungs from the lowest to the highest. The solver only escalates until the hand-back is verified."""

    version: Literal[1]
    name: str
    hand_back: HandBack = HandBack()
    asking: QuestionSettings = QuestionSettings()
    tell: TellSettings = TellSettings()
    standoff: StandoffSettings = StandoffSettings()
    words: GuidancePolicy = GuidancePolicy()
    waits: WaitPolicy
    approval: Approval = Approval()
    rungs: tuple[AnyRung, ...] = Field(alias="rung", min_length=1)

    @field_validator("rungs", mode="before")
    @classmethod
    def _former_kinds(cls, rungs: object) -> object:
        """Read ladders that were written before the kind `rules` was called `reasoner`."""
        if not isinstance(rungs, (list, tuple)):
            return rungs
        former = {"kind": FIRST_REASONER}
        return [rung | former if isinstance(rung, dict) and rung.get("kind") == FORMER_KIND else rung for rung in rungs]

    @field_validator("rungs")
    @classmethod
    def _in_order(cls, rungs: tuple[AnyRung, ...]) -> tuple[AnyRung, ...]:
        moves = [rung.move() for rung in rungs]
        if any(isinstance(move, CheckForWait) for move in moves[1:]):
            raise ValueError("the rung `wait` must be the first")
        if any(isinstance(move, CallAssistance) for move in moves[:-1]):
            raise ValueError("the rung `remote` must be the last: it stops the vehicle")
        if all(isinstance(move, CheckForWait) for move in moves):
            raise ValueError("a rung above `wait` is missing: add one of kind `reasoner`")
        return rungs

    def guard_policy(self) -> GuardPolicy:
        """Return the guard's policy with this ladder's approvals and waits."""
        return GuardPolicy(
            releases=dict(self.approval.behaviors),
            solid_line=self.approval.solid_line,
            authority=self.approval.authority,
            emergency_scene=self.approval.emergency_scene,
            waits=self.waits.limits(),
        )
