"""From a question to a plan under way: asking, taking answers, judging, performing."""

from __future__ import annotations

from stucksolver.decision import CONTINUE, Directive, RecoveryPlan, Replan, asks_for, releases
from stucksolver.detect import Trigger
from stucksolver.guard import NOBODY, Reject, RejectCode, Verdict
from stucksolver.ladder import AskPerson, AskReasoner, Assist, Resume
from stucksolver.reason import ReasonerError
from stucksolver.scene import AttemptEnd, Status
from stucksolver.solver.events import EventKind
from stucksolver.solver.execution import STAND, Outcome
from stucksolver.solver.failures import GOT_ON_M, TEXTS, passes, signature
from stucksolver.solver.helping import why_stopped
from stucksolver.solver.panel import Answer, Held
from stucksolver.solver.people import People
from stucksolver.solver.questions import QuestionKind, Reply
from stucksolver.solver.running import Judged
from stucksolver.solver.senses import Read

HARDLY_BEGUN_M = 2.0
"""A plan given up for traffic before that much of it was driven waits for the next gap as it is."""
STANDS_THERE = "; it stands: the way back into the lane is not free"
OBSERVED_AGAIN_S = 5.0
"""An observer who found a plan looks again this much later."""


class Deliberation(People):
    """One question, one plan at a time."""

    def _next(self, status: Status, trigger: Trigger | None, read: Read) -> Directive:
        """Nothing is under way: ask whoever is due."""
        now, pending = status.time_s, self._desk.pending
        if pending is not None and self._desk.expired(now):
            self._unanswered(pending, now)
        elif pending is not None and pending.kind is QuestionKind.APPROVAL:
            return self._resting
        if self._held is not None:
            return self._hold(self._held, status, read)
        if self._words.now is not None:
            move = self._words_climb.move
            if self._words_climb.ready(now) and isinstance(move, AskReasoner):
                self._ask(move, status, Trigger.GUIDANCE, read)
            return self._resting
        if self._climb.exhausted:
            self._climb_on(now)
        if not self._climb.ready(now):
            return self._resting
        return self._on_rung(status, trigger, read)

    def _on_rung(self, status: Status, trigger: Trigger | None, read: Read) -> Directive:
        move, now = self._climb.move, status.time_s
        if isinstance(move, Assist) and self._stop is None:
            return self._help(move, status, read)
        if isinstance(move, AskPerson) and self._desk.pending is None:
            left = self._climb.since_s + move.within_s - now
            if left <= 0.0:
                self._climb_on(now)
                return self._resting
            text = f"I cannot get on: {why_stopped(self._asking.scene, self._failures.attempts)}. What shall I do?"
            self._question(now, QuestionKind.ADVICE, move.to, text, within_s=left)
        if self._stop is not None and self._desk.pending is None:
            # Another question, about a plan for a passenger's words, took the place of the call.
            self._call_for_help(now, self._stop.reason)
        whom = move if isinstance(move, AskReasoner) else self._climb.lowest
        if whom is not None and self._resumes is not Resume.OPERATOR:
            self._ask(whom, status, trigger or Trigger.SPEED, read)
        return self._resting

    # ---- asking

    def _ask(self, move: AskReasoner, status: Status, trigger: Trigger, read: Read) -> None:
        now = status.time_s
        self._trigger = trigger
        seen = self._running.senses.look(read, now)
        self._look_back(status)
        self._tell(now, EventKind.TRIGGERED, trigger.value)
        outlived = self._climb.outlived(now)
        try:
            screen = self._climb.screens
            check = None if seen is None else self._running.second_opinion(seen, now, self._words.reading)
            self._asking.ask(move, status, self._words.now, self._failures.attempts, screen, outlived, check)
        except ReasonerError as error:
            self._no_answer(status, error)

    def _look_back(self, status: Status) -> None:
        """Still immobilized after a finished plan: did that plan change anything?"""
        done, self._done = self._done, None
        if done is None or self._words.now is not None or status.progress_m - done[1] >= GOT_ON_M:
            return
        if not self._failures.may_be_useless(done[0]):
            return
        self._failures.useless(done[0])
        self._failures.note(done[0], AttemptEnd.USELESS, self._stack_s(status.time_s))
        self._tell(status.time_s, EventKind.USELESS, TEXTS[AttemptEnd.USELESS])

    def _take_answer(self, status: Status, trigger: Trigger | None, read: Read) -> Directive:
        try:
            answer = self._asking.poll(status.time_s)
        except ReasonerError as error:
            self._no_answer(status, error)
            return self._resting
        if answer is None:
            return self._resting
        if answer.decision.plan is None or self._only_looks:
            self._no_plan(answer, status)
            return self._resting
        return self._judge(answer, answer.decision.plan, status, trigger, read)

    @property
    def _only_looks(self) -> bool:
        """In the stop of the last rung: does a plan of the reasoner not count?"""
        return self._stop is not None and self._words.now is None and self._resumes is not Resume.PLAN

    def _no_answer(self, status: Status, error: ReasonerError) -> None:
        self._begin(status)
        self._tell(status.time_s, EventKind.FAILED, f"the reasoner gave no answer: {error}")
        self._failed(status.time_s)

    def _no_plan(self, answer: Answer, status: Status) -> None:
        now, analysis = status.time_s, answer.decision.analysis
        if self._words.now is not None:
            self._begin(status)
            self._tell_decision(now, answer, None)
            self._words_climb.pause(now + self.ladder.asking.recheck_s)
            return
        waiting = self._climb.waits(analysis.wait, now)
        if not waiting:
            self._begin(status)
        self._tell_decision(now, answer, None, waiting=waiting)
        if self._free_again():
            self._release(now, "the way is free")
        elif not waiting:
            self._failed(now)

    # ---- judging

    def _judge(
        self, answer: Answer, plan: RecoveryPlan, status: Status, trigger: Trigger | None, read: Read
    ) -> Directive:
        """Check a plan against the world as it is now, not as it was when the question was asked."""
        now, reading = status.time_s, self._words.reading
        self._begin(status)
        if trigger is None and not asks_for(reading, plan) and self._stop is None:
            gone = Reject(code=RejectCode.NOT_IMMOBILIZED, detail="the vehicle moves again")
            self._tell_decision(now, answer, Verdict(rejects=(gone,)))
            return CONTINUE
        judged = self._running.judge(
            plan,
            read,
            now,
            scene=self._asking.scene,
            failures=self._failures,
            guided=releases(reading, plan),
            approvals=self._approved.get(signature(plan), NOBODY),
        )
        if judged is None:
            self._tell(now, EventKind.FAILED, "there are no surroundings to check the plan against")
            self._failed(now)
            return self._resting
        self._tell_decision(now, answer, judged.verdict)
        if self._observe_only:
            self._climb.pause(now + OBSERVED_AGAIN_S)
            return CONTINUE
        if judged.verdict.accepted:
            return self._start(judged, status, read, answer)
        if judged.need is not None:
            self._ask_for_yes(judged, answer, now)
        else:
            self._refused(judged, answer, status, trigger, read)
        return self._resting

    def _hold(self, held: Held, status: Status, read: Read) -> Directive:
        """A plan that waits for a gap in the traffic: is this the moment?"""
        now = status.time_s
        judged = self._running.judge(
            held.plan,
            read,
            now,
            scene=self._asking.scene,
            failures=self._failures,
            guided=releases(self._words.reading, held.plan),
            approvals=self._approved.get(signature(held.plan), NOBODY),
            again=True,
        )
        if judged is not None and judged.verdict.accepted:
            self._held = None
            self._tell_decision(now, held.answer, judged.verdict)
            return self._start(judged, status, read, held.answer)
        if judged is None or not judged.passing or now >= held.until_s:
            self._held = None
            if judged is not None:
                self._failures.note(held.plan, AttemptEnd.REFUSED, self._stack_s(now), verdict=judged.verdict)
        return self._resting

    def _refused(self, judged: Judged, answer: Answer, status: Status, trigger: Trigger | None, read: Read) -> None:
        """Keep it for a gap where traffic is all; else tell the reasoner why, at once while repair rounds last."""
        now = status.time_s
        if judged.passing:
            self._held = Held(answer, judged.plan, now + self.ladder.asking.hold_s)
            return
        self._failures.note(judged.plan, AttemptEnd.REFUSED, self._stack_s(now), verdict=judged.verdict)
        climb = self._words_climb if self._words.now is not None else self._climb
        if climb.may_repair(now):
            self._next(status, trigger, read)
        else:
            self._failed(now)

    def _start(self, judged: Judged, status: Status, read: Read, answer: Answer | None = None) -> Directive:
        now = status.time_s
        self._driven = answer
        self._climb.begun()
        self._words_climb.begun()
        self._running.start(judged)
        self._done, self._begun_m = None, status.progress_m
        self._words.doing = self._words.now
        self._helped, self._stays = True, False
        self._desk.withdraw()
        if self._stop is not None:
            self._release(now, "a plan was accepted")
        self._tell(now, EventKind.STARTED, ", ".join(b.name for b in judged.plan.behaviors))
        return self._perform(status, read, judged)

    def _perform(self, status: Status, read: Read, judged: Judged | None = None) -> Directive:
        execution, now = self._running.execution, status.time_s
        assert execution is not None
        result = self._running.tick(read, now, judged.view if judged else None)
        if not isinstance(result, Outcome):
            return result
        plan, verdict = execution.plan, execution.last_verdict
        spoken, self._words.doing = self._words.doing, None
        kind = EventKind.FINISHED if result.finished else EventKind.ABORTED
        self._stays = not result.finished and not self._running.clear_to_hand_back(read, now)
        self._tell(now, kind, result.text + (STANDS_THERE if self._stays else ""))
        if not result.finished:
            text = f"aborted: {result.text}"
            self._failures.note(plan, AttemptEnd.GIVEN_UP, self._stack_s(now), text=text, verdict=result.verdict)
            self._failures.aborted(plan, verdict)
            passing = passes(verdict, frozenset())
            self._failed(now, counts=not passing)
            taken_back = self._running.withdrawn
            hardly_begun = status.progress_m - self._begun_m < HARDLY_BEGUN_M
            if passing and hardly_begun and self._driven is not None and not taken_back:
                self._held = Held(self._driven, plan, now + self.ladder.asking.hold_s, self._begun_m)
            return CONTINUE
        if spoken is not None and spoken is self._words.now:
            self._end_words(now, "done")
        self._done = (plan, self._begun_m)
        move = self._climb.move
        if self._driven is None and isinstance(move, Assist) and self._running.may_stop(read, now):
            return self._halt(move, now)  # at once: the stack would drive back to where it was blocked
        self._climb.failed(now)
        self._detector.forget()
        return Replan(route_start=plan.route_start) if plan.replan_route else CONTINUE

    def _still_there(self, status: Status) -> bool:
        """Does a plan, given up right after its start, wait for the next gap while the vehicle has not driven on?"""
        begun = None if self._held is None else self._held.from_m
        return begun is not None and status.progress_m - begun < HARDLY_BEGUN_M

    def _stay(self, status: Status, read: Read) -> Directive:
        """A plan was given up: stand until the stack can drive on from here, or another plan begins."""
        now = status.time_s
        self._stays = not status.at_destination and not self._running.clear_to_hand_back(read, now)
        if self._stays:
            return STAND
        self._tell(now, EventKind.RELEASED, "the way back into the lane is free")
        return CONTINUE

    def _replied(self, reply: Reply, status: Status, trigger: Trigger | None, read: Read) -> Directive:
        """A person's yes or no."""
        now, question = status.time_s, reply.question
        said = "yes" if reply.yes else "no"
        self._tell(now, EventKind.ANSWERED, f"{reply.by}: {said}", question=question, answer=reply.yes)
        if question.kind is QuestionKind.ASSISTANCE:
            return self._helped_out(reply.yes, now)
        answer, self._for_approval = self._for_approval, None
        if not reply.yes or answer is None or question.plan is None:
            self._denied(question, now)
            return self._resting
        self._agreed(question)
        return self._judge(answer, question.plan, status, trigger, read)

    def _help(self, move: Assist, status: Status, read: Read) -> Directive:
        """The last rung: to the best place in reach, where a plan for that is accepted; then stop, where one may stand.

        Where nobody may, help is called, the vehicle is not held, and a way out is looked for again and again.
        """
        now = status.time_s
        may_stop = self._running.may_stop(read, now)
        if not may_stop or (move.pull_over and not self._tried_aside):
            self._tried_aside = True
            judged = self._running.aside(read, now, scene=self._asking.scene, failures=self._failures)
            if judged is not None and judged.verdict.accepted:
                return self._start(judged, status, read)
        return self._halt(move, now) if may_stop else self._not_held(move, now)
