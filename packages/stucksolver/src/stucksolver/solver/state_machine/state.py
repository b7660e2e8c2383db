"""The state of the solver: frozen values that determine everything that may happen next."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType

from stucksolver.guard import Approvals
from stucksolver.immobilization import Trigger
from stucksolver.plan import CONTINUE, Continue, RecoveryPlan, SafeStop
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.scene import Claim, Guidance, Interpretation, Scene
from stucksolver.solver.notices import Notice, StandstillReason
from stucksolver.solver.query import Query
from stucksolver.solver.questions import Question
from stucksolver.solver.recovery_watch import RecoveryWatch
from stucksolver.solver.state_machine.blockers import Blocker
from stucksolver.solver.state_machine.escalation import Escalation
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.history import AttemptHistory, Signature


class StateName(str, Enum):
    """The named states. The first five are activities; the others say what the vehicle does meanwhile."""

    MONITORING = "monitoring"
    """Nothing is asked and nothing runs. The status is watched, and the next rung of the ladder will be asked."""
    QUERYING = "querying"
    """A reasoner is answering a question about the scene."""
    AWAITING_APPROVAL = "awaiting approval"
    """A plan lacks only a person's approval, and the person has been asked."""
    AWAITING_GAP = "awaiting a gap"
    """Only traffic prevents a plan. The guard checks it on every tick until there is a gap or the time is over."""
    EXECUTING = "executing"
    """The stack executes a plan, and the guard checks it on every tick."""
    DRIVING = "driving"
    """The stack drives by itself."""
    HOLDING = "holding"
    """The driver's own next second is not clear: the vehicle is held until it is, or until the limit of the hold."""
    MINIMAL_RISK = "minimal risk condition"
    """The vehicle is stopped behind what blocks its path, at a place where it may stand, and help has been called."""


@dataclass(frozen=True)
class Monitoring:
    """Nothing is asked and nothing runs."""

    name = StateName.MONITORING


@dataclass(frozen=True)
class Querying:
    """A reasoner is answering a question."""

    query: Query

    name = StateName.QUERYING


@dataclass(frozen=True)
class AwaitingApproval:
    """The plan lacks only a person's approval. `answer` is where it came from."""

    answer: ReasonerAnswer

    name = StateName.AWAITING_APPROVAL


@dataclass(frozen=True)
class AwaitingGap:
    """A plan that only traffic prevents.

    Attributes:
        answer: Where the plan came from.
        plan: The plan.
        until_s: The plan is dropped at this time (s, the solver's own).
        from_m: Progress on the route at its start (m) if it was given up for traffic right after that; else None.
    """

    answer: ReasonerAnswer
    plan: RecoveryPlan
    until_s: float
    from_m: float | None = None

    name = StateName.AWAITING_GAP


@dataclass(frozen=True)
class Executing:
    """A running plan.

    Attributes:
        execution: The plan's execution.
        answer: Where the plan came from; None for the way to the roadside.
        words: The words that it follows, if any.
        begun_m: Progress on the route at its start (m).
        withdrawn: True if words withdrew it; it then ends as soon as that is safe.
    """

    execution: Execution
    answer: ReasonerAnswer | None
    words: Guidance | None
    begun_m: float
    withdrawn: bool = False

    name = StateName.EXECUTING


Activity = Monitoring | Querying | AwaitingApproval | AwaitingGap | Executing


@dataclass(frozen=True)
class Driving:
    """The stack drives by itself."""

    name = StateName.DRIVING

    @property
    def directive(self) -> Continue:
        """The directive: continue."""
        return CONTINUE


@dataclass(frozen=True)
class Holding:
    """The vehicle is held where its driver would touch something. Each tick checks whether it must still be held.

    Attributes:
        since_s: Since when (s, the solver's own time).
        brake_mps2: Deceleration of the stop (m/s²); None for a normal one.
    """

    since_s: float
    brake_mps2: float | None = None

    name = StateName.HOLDING

    @property
    def directive(self) -> Continue:
        """The directive: continue."""
        return CONTINUE


@dataclass(frozen=True)
class MinimalRisk:
    """The vehicle is stopped and help has been called.

    Attributes:
        stop: The stop that was ordered.
        was: The posture to return to on release.
        since_s: Since when (s, the solver's own time).
        gap_m: The smallest gap so far to what blocks the path (m).
        free_since_s: Since when the stop has had no reason left (s); None while it has one.
    """

    stop: SafeStop
    was: Driving | Holding
    since_s: float
    gap_m: float
    free_since_s: float | None = None

    name = StateName.MINIMAL_RISK

    @property
    def directive(self) -> SafeStop:
        """The directive: the stop that was ordered."""
        return self.stop


Posture = Driving | Holding | MinimalRisk


@dataclass(frozen=True)
class ActiveGuidance:
    """The passenger's words that count now, and since when (s, the solver's own time)."""

    words: Guidance
    since_s: float


@dataclass(frozen=True)
class Standstill:
    """A time without progress, and what people know about it.

    Attributes:
        since_s: Since when (s, the solver's own time).
        from_m: Progress on the route at its beginning (m).
        reason: What keeps the vehicle from going on; None until it is known.
        told: The notices to people, the last one for each, with their times (s, the solver's own).
        in_vain_s: Since when motion has been commanded without an effect (s); None if it is not.
        in_vain_backwards: True if that motion is backwards.
        immovable: True if the vehicle does not move although it drives.
    """

    since_s: float
    from_m: float
    reason: StandstillReason | None = None
    told: tuple[tuple[Notice, float], ...] = ()
    in_vain_s: float | None = None
    in_vain_backwards: bool = False
    immovable: bool = False


@dataclass(frozen=True)
class Intervention:
    """An intervention: from the first answer that is not a legitimate wait to a verified hand-back. Numbers start
    at 1.
    """

    number: int
    blocker: Blocker | None = None
    """The object in the path at its beginning."""
    recovered: bool = False
    queue_moved: bool = False
    """True if there was enough progress for a recovery, but the blocker was still ahead."""
    helped: bool = False
    """True if a plan was started since the last recovery."""
    done: tuple[RecoveryPlan, float] | None = None
    """The last finished plan, with the progress on the route at its start (m)."""
    tried_aside: bool = False
    """True if pulling over was tried before the stop."""
    approved: Mapping[Signature, Approvals] = field(default_factory=lambda: MappingProxyType({}))
    """What people have approved, by plan."""
    handed_back: bool = False
    """True if the stack has got control back: from then on the guard watches what its driver is about to touch."""
    near_contacts: int = 0
    """How often the driver had to be stopped after a hand-back."""
    stop_is_spent: bool = False
    """True if a stop has ended without an operator: the vehicle is not stopped again in this intervention."""
    course: tuple[tuple[float, float, float, float], ...] = ()
    """The ego's last poses after a hand-back: time (s), x, y (m), heading (rad)."""


@dataclass(frozen=True)
class State:
    """Everything that the next step depends on, except its inputs. Times are the solver's own (s)."""

    escalation: Escalation
    """The place on the ladder."""
    guidance_escalation: Escalation
    """The place on the ladder for a plan that follows words, without the rungs of people."""
    history: AttemptHistory
    progress: RecoveryWatch
    activity: Activity = Monitoring()
    posture: Posture = Driving()
    question: Question | None = None
    """The open question to a person."""
    question_since_s: float = 0.0
    questions: int = 0
    """Number of questions asked so far."""
    queries: int = 0
    standstill: Standstill | None = None
    """The present standstill; None while the vehicle gets on."""
    notices: int = 0
    """Number of notices to people so far."""
    words: ActiveGuidance | None = None
    claims: Mapping[Claim, float] = field(default_factory=lambda: MappingProxyType({}))
    """What people have claimed about the world, and until when each claim is believed (s)."""
    doubts: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """Objects that perception is doubted about, by id, and until when (s); see `doubts`."""
    barred_m: float | None = None
    """Progress at which somebody last said that what lies ahead must not be driven over (m); None once it is behind."""
    stop_said_s: float | None = None
    """When the last call to stay or stop was said (s, the solver's own time)."""
    letting_out: bool = False
    """True if the vehicle has stopped for somebody to get out. It stays until it is told to go."""
    clarification_asked: bool = False
    """True if the passenger was already asked what the last words meant."""
    intervention: Intervention | None = None
    interventions: int = 0
    scene: Scene | None = None
    """The scene of the last question to a reasoner."""
    trigger: Trigger | None = None
    declined_at_m: float | None = None
    """Progress at which the passenger refused the plan (m); None if nothing is refused."""
    detector_ignored_until_s: float | None = None
    """Detector output before this time is ignored, because a plan has finished since."""
    senses_fault: str | None = None
    camera_fault: str | None = None
    reported_fault: str | None = None
    """The current fault, if it was reported already."""

    @property
    def reading(self) -> Interpretation | None:
        """How the words that count now were understood."""
        return None if self.words is None else self.words.words.reading

    @property
    def names(self) -> tuple[StateName, StateName]:
        """The current activity, and what the vehicle does meanwhile."""
        return self.activity.name, self.posture.name

    @property
    def engaged(self) -> bool:
        """True if a tick has something to check even without a trigger."""
        return (
            self.intervention is not None
            or self.progress.active
            or self.words is not None
            or self.question is not None
            or self.letting_out
            or (self.standstill is not None and bool(self.standstill.told))
            or not isinstance(self.activity, Monitoring)
            or not isinstance(self.posture, Driving)
        )

    @property
    def settled(self) -> bool:
        """True if an intervention may be closed because nothing is being waited for."""
        return (
            self.words is None
            and self.question is None
            and isinstance(self.activity, Monitoring | AwaitingGap)
            and isinstance(self.posture, Driving)
        )
