"""What the solver tells whoever listens: one event for each thing that a reviewer would want to know."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from stucksolver.decision import Decision, Directive, RecoveryPlan
from stucksolver.guard import Approvals, Verdict
from stucksolver.reason import Trace
from stucksolver.scene import Reading, Scene, Surroundings
from stucksolver.scene.model import Model
from stucksolver.solver.machine.execution import ExecutionOutcome
from stucksolver.solver.questions import Question


class EventKind(str, Enum):
    """What an event tells of."""

    TRIGGERED = "triggered"
    DECIDED = "decided"
    STARTED = "started"
    ABORTED = "aborted"
    FINISHED = "finished"
    USELESS = "useless"
    """The plan that finished last changed nothing: the vehicle is where it was, and still immobilized."""
    RECOVERED = "recovered"
    GUIDANCE = "guidance"
    GUIDANCE_ENDED = "guidance_ended"
    ASKED_BACK = "asked_back"
    """Words were not understood; the text asks what was meant. Answered by other words."""
    DISAGREED = "disagreed"
    """A reasoner that looks at the picture contradicts perception; what it grants counts as unknown for a while."""
    FAILED = "failed"
    CANCELLED = "cancelled"
    """A question to a reasoner or a person is not wanted any more: the situation cleared."""
    ESCALATED = "escalated"
    ASKED = "asked"
    """A person was asked."""
    ANSWERED = "answered"
    STOPPED = "stopped"
    RELEASED = "released"
    CLOSED = "closed"
    """The intervention is over."""
    FAULT = "fault"
    """The clock, the surroundings or a listener did something that they should not."""


class Event(Model):
    """Something that happened, at time `time_s` of the stack's clock."""

    time_s: float
    kind: EventKind
    text: str
    intervention: int | None = None
    """Counts from 1; None while nothing but a legitimate wait goes on."""
    rung: str | None = None
    trigger: str | None = None
    scene: Scene | None = None
    reasoner: str | None = None
    decision: Decision | None = None
    waiting: bool = False
    """A decision that says to wait, and the ladder agrees."""
    trace: Trace | None = None
    verdict: Verdict | None = None
    question: Question | None = None
    answer: bool | None = None
    """A person's yes or no, with `EventKind.ANSWERED`."""
    reading: Reading | None = None
    """What a passenger's words were read as."""


Listener = Callable[[Event], None]


@dataclass(frozen=True)
class Judgement:
    """All that the verdict on a proposed plan depends on. `now_s`: the solver's own time, which never jumps."""

    time_s: float
    now_s: float
    plan: RecoveryPlan
    surroundings: Surroundings
    guided: bool
    approvals: Approvals
    verdict: Verdict


@dataclass(frozen=True)
class Tick:
    """All that the verdict on a running plan depends on at one tick, and what came of it."""

    time_s: float
    now_s: float
    surroundings: Surroundings
    withdrawn: bool
    """Taken back by words before this tick."""
    result: Directive | ExecutionOutcome
    verdict: Verdict


Told = Event | Judgement | Tick
"""What a transition tells, in order."""
