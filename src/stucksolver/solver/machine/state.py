"""What the solver knows and is about: frozen values, from which everything that may happen next follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from types import MappingProxyType

from stucksolver.decision import CONTINUE, Continue, RecoveryPlan, SafeStop
from stucksolver.detect import Trigger
from stucksolver.guard import Approvals
from stucksolver.reason import Answer
from stucksolver.scene import Claim, Guidance, Reading, Scene
from stucksolver.solver.machine.escalation import Escalation
from stucksolver.solver.machine.execution import Execution
from stucksolver.solver.machine.history import History, Signature
from stucksolver.solver.progress import ProgressWatch
from stucksolver.solver.query import Query
from stucksolver.solver.questions import Question


class StateName(str, Enum):
    """The named states. The first five are activities, the others say what the vehicle does meanwhile."""

    MONITORING = "monitoring"
    """Nothing is asked and nothing runs: the status is watched, and whoever is due on the ladder will be asked."""
    QUERYING = "querying"
    """A reasoner has a question about the scene."""
    AWAITING_APPROVAL = "awaiting approval"
    """A plan lacks only the yes of a person, who has been asked for it."""
    AWAITING_GAP = "awaiting a gap"
    """Only traffic speaks against a plan: the guard looks at it on every tick until a gap comes, or time is over."""
    EXECUTING = "executing"
    """The stack carries out a plan, and the guard looks at it on every tick."""
    DRIVING = "driving"
    """The stack drives as it likes."""
    HOLDING = "holding"
    """A plan was given up where the stack would turn into what stands there: the vehicle is held until that is free."""
    MINIMAL_RISK = "minimal risk condition"
    """The vehicle is stopped where one may stand, and help has been called."""


@dataclass(frozen=True)
class Monitoring:
    """Nothing is asked, and nothing runs."""

    name = StateName.MONITORING


@dataclass(frozen=True)
class Querying:
    """A reasoner has a question."""

    query: Query

    name = StateName.QUERYING


@dataclass(frozen=True)
class AwaitingApproval:
    """The plan in question lacks only a yes; `answer` is what it came from."""

    answer: Answer

    name = StateName.AWAITING_APPROVAL


@dataclass(frozen=True)
class AwaitingGap:
    """A plan that only traffic speaks against.

    `until_s`: it is dropped at this time. `from_m`: progress on the route when it was begun (m), for one that was given
    up for the traffic right after its start; else None.
    """

    answer: Answer
    plan: RecoveryPlan
    until_s: float
    from_m: float | None = None

    name = StateName.AWAITING_GAP


@dataclass(frozen=True)
class Executing:
    """A plan under way.

    `answer`: what it comes from, None for the way to the roadside. `words`: those that it follows. `begun_m`: progress
    on the route at its start (m). `withdrawn`: it was taken back by words, and ends as soon as that is safe.
    """

    execution: Execution
    answer: Answer | None
    words: Guidance | None
    begun_m: float
    withdrawn: bool = False

    name = StateName.EXECUTING


Activity = Monitoring | Querying | AwaitingApproval | AwaitingGap | Executing


@dataclass(frozen=True)
class Driving:
    """The stack drives as it likes."""

    name = StateName.DRIVING

    @property
    def directive(self) -> Continue:
        """The stack goes on by itself."""
        return CONTINUE


@dataclass(frozen=True)
class Holding:
    """The vehicle is held where a plan was given up. Each tick looks whether it still must be."""

    name = StateName.HOLDING

    @property
    def directive(self) -> Continue:
        """The stack goes on by itself."""
        return CONTINUE


@dataclass(frozen=True)
class MinimalRisk:
    """Stopped, with help called. `blocked`: did something stand in the way? `was`: what to go back to on release."""

    stop: SafeStop
    blocked: bool
    was: Driving | Holding

    name = StateName.MINIMAL_RISK

    @property
    def directive(self) -> SafeStop:
        """The stop that was ordered."""
        return self.stop


Posture = Driving | Holding | MinimalRisk


@dataclass(frozen=True)
class WordsInForce:
    """A passenger's words that count now, and since when, in the solver's own time."""

    words: Guidance
    since_s: float


@dataclass(frozen=True)
class Intervention:
    """From the first answer that is no legitimate wait to a verified hand-back. `number` counts from 1."""

    number: int
    recovered: bool = False
    helped: bool = False
    """Has a plan been started since the last recovery?"""
    done: tuple[RecoveryPlan, float] | None = None
    """The plan that finished last, with the progress on the route at its start (m)."""
    tried_aside: bool = False
    """Was pulling over tried before the stop?"""
    approved: Mapping[Signature, Approvals] = field(default_factory=lambda: MappingProxyType({}))
    """What people have agreed to, by plan."""


@dataclass(frozen=True)
class State:
    """All that the next step depends on, but the inputs of its tick. Times are the solver's own, seconds."""

    escalation: Escalation
    """Where on the ladder it is."""
    words_escalation: Escalation
    """The same for a plan that follows words: no rungs of people."""
    history: History
    progress: ProgressWatch
    activity: Activity = Monitoring()
    posture: Posture = Driving()
    question: Question | None = None
    """What a person is asked now."""
    question_since_s: float = 0.0
    questions: int = 0
    """Asked so far."""
    queries: int = 0
    words: WordsInForce | None = None
    claims: Mapping[Claim, float] = field(default_factory=lambda: MappingProxyType({}))
    """What people have said of the world, and until when it is believed."""
    doubts: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """What perception is not believed about, by object's id, and until when (see `doubts`)."""
    asked_back: bool = False
    """Were the last words asked back already?"""
    intervention: Intervention | None = None
    interventions: int = 0
    scene: Scene | None = None
    """What the last question to a reasoner was about."""
    trigger: Trigger | None = None
    refused_m: float | None = None
    """Progress at which the passenger refused what would have been done (m); None where nothing is refused."""
    afresh_s: float | None = None
    """What the detector saw before this time says nothing any more: a plan finished."""
    senses_fault: str | None = None
    camera_fault: str | None = None
    told_fault: str | None = None
    """The fault that goes on, and was told."""

    @property
    def reading(self) -> Reading | None:
        """What the words that count now were read as."""
        return None if self.words is None else self.words.words.reading

    @property
    def names(self) -> tuple[StateName, StateName]:
        """The activity, and what the vehicle does meanwhile."""
        return self.activity.name, self.posture.name

    @property
    def engaged(self) -> bool:
        """Is anything going on that a tick must look at, even while nothing triggers?"""
        return (
            self.intervention is not None
            or self.progress.on
            or self.words is not None
            or self.question is not None
            or not isinstance(self.activity, Monitoring)
            or not isinstance(self.posture, Driving)
        )

    @property
    def settled(self) -> bool:
        """May an intervention be closed: is nothing and nobody being waited for?"""
        return (
            self.words is None
            and self.question is None
            and isinstance(self.activity, Monitoring | AwaitingGap)
            and isinstance(self.posture, Driving)
        )

    def but(self, **changes: object) -> State:
        """The same with these fields changed."""
        return replace(self, **changes)  # type: ignore[arg-type]
