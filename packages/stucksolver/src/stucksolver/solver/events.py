"""Events that the solver sends to its listeners."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from stucksolver.guard import Approvals, Verdict
from stucksolver.plan import Decision, Directive, RecoveryPlan
from stucksolver.reasoners import ReasonerTrace
from stucksolver.scene import Interpretation, Scene, Surroundings
from stucksolver.scene.base_model import FrozenModel
from stucksolver.solver.notices import Notice
from stucksolver.solver.questions import Question
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome


class EventKind(str, Enum):
    """Kind of an event."""

    TRIGGERED = "triggered"
    DECIDED = "decided"
    STARTED = "started"
    ABORTED = "aborted"
    FINISHED = "finished"
    INEFFECTIVE = "useless"
    """The last plan finished, but the ego made no progress and is still immobilized."""
    RECOVERED = "recovered"
    GUIDANCE = "guidance"
    GUIDANCE_ENDED = "guidance_ended"
    ASKED_BACK = "asked_back"
    """The passenger's utterance was not understood. The text asks for its meaning; the reply is an utterance."""
    PERCEPTION_DISPUTED = "disagreed"
    """A reasoner that uses the image contradicts perception. The object that perception allowed counts as unknown for
    some time.
    """
    FAILED = "failed"
    CANCELLED = "cancelled"
    """A query to a reasoner or a question to a person was withdrawn because the situation cleared."""
    ESCALATED = "escalated"
    ASKED = "asked"
    """A person was asked a question."""
    ANSWERED = "answered"
    WAITING = "waiting"
    """A person is informed why the vehicle stands still (`Event.notice`). Nobody has to act on it."""
    WAITING_ENDED = "waiting_ended"
    """Such a notice is withdrawn, because the vehicle has moved on."""
    QUEUE_MOVED = "queue_moved"
    """Enough progress for a recovery, but the blocker is still ahead: the ego has only followed it."""
    HELD = "held"
    """After a hand-back, the driver was stopped just before a contact."""
    STOPPED = "stopped"
    RELEASED = "released"
    CLOSED = "closed"
    """The intervention has ended."""
    FAULT = "fault"
    """Fault of the clock, the surroundings or a listener."""


class Event(FrozenModel):
    """One event. `time_s` is the time of the stack's clock."""

    time_s: float
    kind: EventKind
    text: str
    intervention: int | None = None
    """Number of the intervention, counted from 1; None during a legitimate wait."""
    rung: str | None = None
    trigger: str | None = None
    scene: Scene | None = None
    reasoner: str | None = None
    decision: Decision | None = None
    waiting: bool = False
    """True if the decision is to wait and the ladder allows the wait."""
    trace: ReasonerTrace | None = None
    verdict: Verdict | None = None
    question: Question | None = None
    notice: Notice | None = None
    answer: bool | None = None
    """Reply of the person, for `EventKind.ANSWERED`."""
    reading: Interpretation | None = None
    """Interpretation of the passenger's utterance."""
    mirrored: bool = False
    """True for left-hand traffic: scene, decision and interpretation are mirrored, and the texts are not."""


Listener = Callable[[Event], None]


@dataclass(frozen=True)
class PlanReview:
    """All inputs of the verdict on a proposed plan. `now_s` is the solver's own time, which never jumps."""

    time_s: float
    now_s: float
    plan: RecoveryPlan
    surroundings: Surroundings
    guided: bool
    approvals: Approvals
    verdict: Verdict


@dataclass(frozen=True)
class ExecutionTick:
    """All inputs of the verdict on a running plan at one tick, and the result."""

    time_s: float
    now_s: float
    surroundings: Surroundings
    withdrawn: bool
    """True if guidance withdrew the plan before this tick."""
    result: Directive | ExecutionOutcome
    verdict: Verdict


StepOutput = Event | PlanReview | ExecutionTick
"""Outputs of a transition, in order."""
