"""StuckSolver with a driver, through its public API only."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

from stucksolver.ladder import FIRST_REASONER, Person
from stucksolver.plan import Directive, SafeStop
from stucksolver.record import Recorder
from stucksolver.solver import Event, EventKind, Question, QuestionError, StuckSolver
from stucksolver_carla.stack import CarlaStack
from stucksolver_carla.stack.front_camera import PictureSource
from stucksolver_eval.results.outcome import InterventionRecord, NoticeRecord, QueryOutcome, QueryRecord, came_to
from stucksolver_eval.systems.system_under_test import SystemLog, TickInfo
from stucksolver_eval.systems.timed_reasoner import TimedReasoner
from stucksolver_passenger.memory import Memory

Listener = Callable[[Event], None]


class SolverSystem:
    """`make_solver` gets the listener for the solver's events; `reasoners` are those that the solver may query."""

    def __init__(
        self,
        stack: CarlaStack,
        reasoners: Sequence[TimedReasoner],
        make_solver: Callable[[Listener], StuckSolver],
        recorder: Recorder | None = None,
        camera: PictureSource | None = None,
        memory: Memory | None = None,
    ) -> None:
        self._stack = stack
        self._camera = camera
        self._reasoners = {reasoner.name: reasoner for reasoner in reasoners}
        self._recorder = recorder
        self._memory = memory
        self._start_s: float | None = None
        self._now = TickInfo(0.0, 0.0, 0.0)
        self._running: InterventionRecord | None = None
        self._listeners: list[Listener] = []
        self.log = SystemLog()
        self.directive: Directive | None = None
        self._decided: Event | None = None
        self._solver = make_solver(self._hear)

    @property
    def solver(self) -> StuckSolver:
        """The solver."""
        return self._solver

    @property
    def stack(self) -> CarlaStack:
        """The vehicle in the solver's form."""
        return self._stack

    @property
    def camera(self) -> PictureSource | None:
        """The front camera, if there is one."""
        return self._camera

    def listen(self, listener: Listener) -> None:
        """Add another listener for the solver's events."""
        self._listeners.append(listener)

    def step(self, now: TickInfo) -> Any:
        """Run one tick of the solver and execute its directive."""
        self._now = now
        directive = self._solver.step(self._stack.status(), self._stack.surroundings)
        if isinstance(directive, SafeStop) and self.log.asked_s is None:
            self.log.asked_s = now.time_s
        self.directive = self._stack.in_map_frame(directive)
        return self._stack.perform(directive)

    def say(self, text: str) -> None:
        """Pass a person's utterance to the solver."""
        self._solver.guide(text)

    def answer(self, yes: bool, by: Person) -> Question | None:
        """Answer the open question. Returns the question, or None if this person may not answer it."""
        question = self._solver.pending_question
        try:
            (self._solver.approve if yes else self._solver.deny)(None, by)
        except QuestionError:
            # A script may answer a question that has closed meanwhile.
            return None
        return question

    def close(self, time_s: float) -> None:
        """End the route.

        Raises:
            RecordError: A record could not be written.
        """
        self._solver.close()
        if self._memory is not None:
            self._memory.close()
            if self._memory.fault is not None:
                print(
                    f"note: some entries of the memory were not stored: {self._memory.fault}",
                    file=sys.stderr,
                    flush=True,
                )
        if self._camera is not None:
            self._camera.close()
        if self._recorder is not None:
            self._recorder.close()
            if self._recorder.error is not None:
                raise self._recorder.error
        if self._running is not None:
            self._end(time_s, False, "the route ended")
        reliabilities = [reasoner.reliability for reasoner in self._reasoners.values()]
        self.log.reliability = [item for item in reliabilities if item is not None]

    def _hear(self, event: Event) -> None:
        now = self._now
        if event.kind is EventKind.TRIGGERED:
            self.log.queries.append(QueryRecord(asked_s=now.time_s))
        elif event.kind is EventKind.DECIDED:
            self._answered(event)
        elif event.kind is EventKind.FAILED:
            self._failed(event)
        elif event.kind is EventKind.STARTED:
            self._began(event)
        elif event.kind in (EventKind.FINISHED, EventKind.ABORTED) and self._running is not None:
            self._end(now.time_s, event.kind is EventKind.FINISHED, event.text)
        elif event.kind is EventKind.WAITING and event.notice is not None:
            self.log.notices.append(NoticeRecord(time_s=now.time_s, to=event.notice.to))
        elif self.log.asked_s is None and (event.kind is EventKind.STOPPED or _calls_operator(event)):
            self.log.asked_s = now.time_s
        for listener in self._listeners:
            listener(event)

    def _answered(self, event: Event) -> None:
        if self.log.queries:
            outcome, verdict = came_to(event.verdict)
            answer = {"answered_s": self._now.time_s, "outcome": outcome, "verdict": verdict}
            asked = self._reasoner_of(event.reasoner or "")
            # The rules that screen for a legitimate wait are none of the reasoners, and cost nothing.
            cost = {} if asked is None else {"took_s": asked.took_s, "tokens": asked.tokens, "usd": asked.usd}
            self.log.queries[-1] = self.log.queries[-1].model_copy(update=answer | cost)
        self._decided = event

    def _reasoner_of(self, name: str) -> TimedReasoner | None:
        """Return the reasoner whose last answer has a name, also if it is a chain; None if it is none of them."""
        return next((asked for asked in self._reasoners.values() if name in (asked.answered_by, asked.name)), None)

    def _failed(self, event: Event) -> None:
        if self.log.queries and self.log.queries[-1].answered_s is None:
            changes = {"outcome": QueryOutcome.FAILED, "verdict": f"failed: {event.text}"}
            self.log.queries[-1] = self.log.queries[-1].model_copy(update=changes)

    def _began(self, event: Event) -> None:
        decided = self._decided
        plan = None if decided is None or decided.decision is None else decided.decision.plan
        behaviors = () if plan is None else plan.behaviors
        guided = decided is not None and decided.trigger == "guidance"
        self._running = InterventionRecord(
            start_s=self._now.time_s,
            end_s=self._now.time_s,
            place_m=self._now.place_m,
            rung="passenger" if guided else event.rung or FIRST_REASONER,
            behaviors=tuple(b.name for b in behaviors),
            moves=any(not b.stands_still for b in behaviors),
            finished=False,
        )
        if any(b.calls_person for b in behaviors) and self.log.asked_s is None:
            self.log.asked_s = self._now.time_s

    def _end(self, time_s: float, finished: bool, text: str) -> None:
        assert self._running is not None
        ended = {"end_s": time_s, "finished": finished, "text": text}
        self.log.interventions.append(self._running.model_copy(update=ended))
        self._running = None


def _calls_operator(event: Event) -> bool:
    """True if the event contains a question to an operator."""
    return event.kind is EventKind.ASKED and event.question is not None and event.question.to == "operator"
