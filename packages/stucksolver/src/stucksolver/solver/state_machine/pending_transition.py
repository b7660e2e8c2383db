"""A transition in progress: the state so far and the events to report. Nothing outside this object changes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

from stucksolver.guard import Verdict
from stucksolver.immobilization import Trigger
from stucksolver.ladder.rung_actions import Person
from stucksolver.plan import Continue, RecoveryPlan, SafeStop
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.scene import Guidance, Interpretation, Status, Surroundings
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.events import Event, EventKind, StepOutput
from stucksolver.solver.notices import Notice, StandstillReason, verdict_reason
from stucksolver.solver.questions import Question, QuestionKind
from stucksolver.solver.state_machine.blockers import blocker_of
from stucksolver.solver.state_machine.inputs import Inputs, SolverSetup, SurroundingsInput
from stucksolver.solver.state_machine.perception_disagreement import Disagreement, mask_disputed, update_disputes
from stucksolver.solver.state_machine.state import AwaitingApproval, Intervention, Monitoring, Querying, State

BLIND_LIMIT_S = 5.0
"""After this long without new surroundings, what was seen before no longer says whether a plan is done, or whether
waiting is right.
"""


GAINED_M = 5.0
"""Progress behind a blocker from which it counts as one that moves on (m): more than the ego creeps up to it. Ours."""


class PendingTransition:
    """Starts from a state and the inputs of one tick; the functions of this package change it step by step."""

    def __init__(self, state: State, inputs: Inputs, setup: SolverSetup) -> None:
        self.state = state
        self.inputs = inputs
        self.setup = setup
        self.told: list[StepOutput] = []
        self.reply = inputs.reply
        """A person's yes or no that has not been handled yet."""

    # ---- the tick

    @property
    def status(self) -> Status:
        """The vehicle's status at this tick."""
        return self.inputs.status

    @property
    def now_s(self) -> float:
        """The solver's own time (s)."""
        return self.inputs.status.time_s

    @property
    def stack_s(self) -> float:
        """The stack's time (s)."""
        return self.now_s - self.inputs.offset_s

    @property
    def resting(self) -> Continue | SafeStop:
        """The directive while no plan is executed."""
        return self.state.posture.directive

    @property
    def onset_s(self) -> float | None:
        """Since when the vehicle has been slow without a good reason (s); None if it is not."""
        slow, waited = self.inputs.slow_since_s, self.state.escalation.last_wait_s
        return slow if slow is None or waited is None else max(slow, waited)

    # ---- looking

    @cached_property
    def sight(self) -> SurroundingsInput:
        """What the senses show. The first look decides for the whole tick."""
        sight = self.inputs.look()
        self.state = replace(self.state, senses_fault=sight.fault)
        return sight

    @property
    def surroundings(self) -> Surroundings | None:
        """The surroundings with doubted objects as unknown; None if nothing was ever seen."""
        found = self.sight.surroundings
        return None if found is None else mask_disputed(found, self.state.doubts, self.now_s)

    @property
    def unseen_s(self) -> float:
        """Age of the surroundings (s); if there are none, the time since anything was seen."""
        found = self.sight.surroundings
        return self.sight.blind_s if found is None else found.age_s

    @property
    def is_blind(self) -> bool:
        """True if nothing new has been seen for long."""
        return self.unseen_s > BLIND_LIMIT_S

    @cached_property
    def view(self) -> FrenetScene | None:
        """The same surroundings in road coordinates."""
        seen = self.surroundings
        return None if seen is None else FrenetScene(seen)

    def doubt(self, found: tuple[Disagreement, ...]) -> None:
        """Report what a reasoner contradicts, and look at the surroundings again."""
        if not found:
            return
        self.tell(EventKind.PERCEPTION_DISPUTED, "; ".join(str(item) for item in found))
        self.state = replace(self.state, doubts=update_disputes(self.state.doubts, found, self.now_s))
        self.__dict__.pop("view", None)

    # ---- reporting

    def tell(
        self,
        kind: EventKind,
        text: str,
        *,
        question: Question | None = None,
        notice: Notice | None = None,
        answer: bool | None = None,
        verdict: Verdict | None = None,
        interpretation: Interpretation | None = None,
    ) -> None:
        """Add an event to this step."""
        event = Event(
            time_s=self.stack_s,
            kind=kind,
            text=text,
            intervention=self._number,
            rung=self.state.escalation.rung,
            scene=None if notice is None else self.state.scene,
            question=question,
            notice=notice,
            answer=answer,
            verdict=verdict,
            reading=interpretation,
        )
        self.told.append(event)

    def tell_words(self, words: Guidance) -> None:
        """Report what was said and how it was understood."""
        self.tell(EventKind.GUIDANCE, words.text, interpretation=words.reading)

    def tell_decision(self, answer: ReasonerAnswer, verdict: Verdict | None, *, waiting: bool = False) -> None:
        """Report a decision, with the guard's verdict on it."""
        trigger = self.state.trigger
        event = Event(
            time_s=self.stack_s,
            kind=EventKind.DECIDED,
            text=answer.decision.rationale,
            intervention=self._number,
            rung=self.state.escalation.rung,
            trigger=trigger.value if trigger else None,
            scene=self.state.scene,
            reasoner=answer.reasoner,
            decision=answer.decision,
            waiting=waiting,
            trace=answer.trace,
            verdict=verdict,
        )
        self.told.append(event)

    def tell_fault(self, fault: str | None) -> None:
        """Report each fault once, when it begins."""
        if fault is not None and fault != self.state.reported_fault:
            self.tell(EventKind.FAULT, fault)
        self.state = replace(self.state, reported_fault=fault)

    @property
    def _number(self) -> int | None:
        """Number of the open intervention."""
        return None if self.state.intervention is None else self.state.intervention.number

    # ---- the intervention

    def begin(self, trigger: Trigger | None) -> None:
        """Begin an intervention at the first answer that is not a legitimate wait."""
        if self.state.intervention is not None:
            return
        number = self.state.interventions + 1
        blocker = blocker_of(self.state.scene, self.status.progress_m, self.setup.ladder.hand_back.gone_m)
        self.state = replace(self.state, intervention=Intervention(number, blocker), interventions=number)
        moving = trigger in (None, Trigger.GUIDANCE) and self.inputs.slow_since_s is None
        progress, _ = self.state.progress.advance(self.status, self.onset_s, None if moving else trigger)
        self.state = replace(self.state, progress=progress)

    def note(self, change: Callable[[Intervention], Intervention]) -> None:
        """Change the open intervention, if there is one."""
        if self.state.intervention is not None:
            self.state = replace(self.state, intervention=change(self.state.intervention))

    def note_reason(self, reason: StandstillReason | None) -> None:
        """Note what keeps the stopped vehicle from going on, for the notices to people."""
        standstill = self.state.standstill
        if standstill is not None and reason is not None:
            self.state = replace(self.state, standstill=replace(standstill, reason=reason))

    def note_verdict(self, verdict: Verdict) -> None:
        """Note the binding constraint of a verdict as this reason; for a repeated plan, what was wrong before."""
        found = verdict_reason(verdict, self.view)
        self.note_reason(found if found is not None or verdict.accepted else self.state.history.reason)

    # ---- the ladder

    def failed(self, *, counts: bool = True) -> None:
        """The last reasoner or person did not help: pause, and count the try if it counts.

        Behind a blocker that moves on now and then, as in a queue, no try counts.
        """
        counts = counts and not self._is_moving_up
        if self.state.words is not None:
            self.state = replace(
                self.state, guidance_escalation=self.state.guidance_escalation.note_failure(self.now_s, counts=False)
            )
        else:
            self.state = replace(self.state, escalation=self.state.escalation.note_failure(self.now_s, counts=counts))

    @property
    def _is_moving_up(self) -> bool:
        """True if the blocker has moved on before, and the present standstill is no longer than in a queue."""
        standstill, under_way = self.state.standstill, self.state.intervention
        behind = None if under_way is None else under_way.blocker
        gained_m = 0.0 if behind is None else self.status.progress_m - behind.from_m
        moves = self.state.history.blocker is not None or gained_m > GAINED_M
        moved_s = self.setup.ladder.waits.queue_moved_within_s
        return moves and standstill is not None and self.now_s - standstill.since_s < moved_s

    def may_repair(self) -> bool:
        """Take one of the rounds in which the reasoner is told why its plan was refused. False if none is left."""
        state = self.state
        if state.words is not None:
            repaired = state.guidance_escalation.repair(self.now_s)
            self.state = replace(self.state, guidance_escalation=repaired or state.guidance_escalation)
        else:
            repaired = state.escalation.repair(self.now_s)
            self.state = replace(self.state, escalation=repaired or state.escalation)
        return repaired is not None

    def climb(self) -> None:
        """Go to the next rung, if there is one."""
        before = self.state.escalation
        self.state = replace(self.state, escalation=before.climbed(self.now_s))
        if not before.is_last:
            self.tell(EventKind.ESCALATED, f"to the rung {self.state.escalation.rung}")

    def pause(self, until_s: float) -> None:
        """Ask nobody before this time (s)."""
        self.state = replace(self.state, escalation=self.state.escalation.paused(until_s))

    # ---- questions

    def drop_query(self) -> bool:
        """Drop the question to a reasoner. Returns True if there was one."""
        asked = isinstance(self.state.activity, Querying)
        if asked:
            self.state = replace(self.state, activity=Monitoring())
        return asked

    def ask_person(
        self,
        kind: QuestionKind,
        to: Person,
        text: str,
        *,
        within_s: float | None = None,
        plan: RecoveryPlan | None = None,
        needs: tuple[str, ...] = (),
    ) -> None:
        """Ask a person a question, replacing the open one."""
        number = self.state.questions + 1
        question = Question(
            id=f"q{number}",
            time_s=self.stack_s,
            kind=kind,
            to=to,
            text=text,
            within_s=within_s,
            plan=plan,
            needs=needs,
        )
        self.reply = None
        self.state = replace(self.state, question=question, question_since_s=self.now_s, questions=number)
        self.tell(EventKind.ASKED, text, question=question)

    def withdraw_question(self) -> Question | None:
        """Close the open question without an answer and return it."""
        question, self.reply = self.state.question, None
        self.state = replace(self.state, question=None)
        if isinstance(self.state.activity, AwaitingApproval):
            self.state = replace(self.state, activity=Monitoring())
        return question
