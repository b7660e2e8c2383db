"""People: the passenger's words, questions for a yes, and the stop in which help is called."""

from __future__ import annotations

import math

from stucksolver.decision import CONTINUE, Directive, GuidanceIntent, SafeStop
from stucksolver.guard import NOBODY
from stucksolver.ladder import Assist, Resume
from stucksolver.ladder.moves import Person
from stucksolver.scene import AttemptEnd, Guidance, Reading
from stucksolver.solver.core import Core
from stucksolver.solver.events import EventKind
from stucksolver.solver.failures import signature
from stucksolver.solver.helping import still_blocked, why_stopped
from stucksolver.solver.panel import Answer
from stucksolver.solver.questions import Question, QuestionKind
from stucksolver.solver.running import Judged
from stucksolver.solver.trial import granted
from stucksolver.words import NoReader, situation_of
from stucksolver.words.fields import STAYS

ASK_BACK = "I did not understand that. Shall I wait, drive on, go round, or take another way?"


class People(Core):
    """Whoever sits in the car, or at a desk far away."""

    # ---- words

    def _hear(self, now: float) -> None:
        """Have new words read, act on those that are understood, and drop those that led to nothing in time."""
        if self._said is not None:
            said, self._said = self._said, None
            question = self._to_be_answered
            situation = situation_of(self._asking.look(), question.text if question else None)
            self._listening.take(said, self._stack_s(now), now, situation)
        heard = self._listening.poll(now)
        if heard is not None:
            self._tell_fault(now, self._listening.fault)
            self._understand(heard, now)
        if self._words.expired(now):
            if self._running.execution is None:
                self._asking.drop()
            last = self._failures.attempts[-1].outcome if self._failures.attempts else "no occasion"
            self._end_words(now, f"expired ({last})")

    @property
    def _to_be_answered(self) -> Question | None:
        """The open question that a yes or no of the passenger answers. "What shall I do?" is answered by a request."""
        asked = self._desk.pending
        answerable = asked is not None and asked.to == "passenger" and asked.kind is not QuestionKind.ADVICE
        return asked if answerable else None

    def _understand(self, words: Guidance, now: float) -> None:
        """Act on a reading: an answer, a refusal, a call to stop, a request, or nothing that concerns the driving."""
        reading = words.reading
        assert reading is not None
        self._tell_words(now, words)
        intent = reading.intent
        if intent in (GuidanceIntent.YES, GuidanceIntent.NO) and self._is_answered(intent, words, now):
            return
        if intent is GuidanceIntent.NONE:
            self._dismiss(words, now, "nothing is asked of the driving")
        elif intent is GuidanceIntent.UNLAWFUL:
            self._dismiss(words, now, "refused: that is not allowed")
        elif intent in (GuidanceIntent.UNCLEAR, GuidanceIntent.YES):
            self._ask_back(words, now)
        else:
            self._take_words(words, now)
            self._asked_back = False
            if intent in STAYS and self._words.now is not None:
                self._hold_back(reading, now)

    def _take_words(self, words: Guidance, now: float) -> None:
        """From now on these count: everything that was about to be done for another reason is dropped."""
        self._words.take(words, now)
        self._words_climb.reset()
        self._climb.quiet_until_s = now
        self._held = None
        self._failures.forget_attempts()
        if self._running.execution is None:
            self._asking.drop()
        pending = self._desk.pending
        if pending is not None and pending.kind is not QuestionKind.ASSISTANCE:
            self._desk.withdraw()
        if self._stop is not None and self._resumes is Resume.OPERATOR:
            self._end_words(now, "only the operator may end this stop")

    def _is_answered(self, intent: GuidanceIntent, words: Guidance, now: float) -> bool:
        """Take yes or no as the answer to the passenger's open question, if there is one that a yes answers."""
        question = self._to_be_answered
        if question is None:
            return False
        self._desk.reply(intent is GuidanceIntent.YES, question.id, "passenger")
        self._dismiss(words, now, f"answers question {question.id}")
        return True

    def _hold_back(self, reading: Reading, now: float) -> None:
        """They ask to stay: a running plan ends by its safe abort, and nothing begins for now.

        A refusal holds until other words are said or the intervention is over; a plain "wait" as long as words last.
        """
        running = self._running.execution is not None
        if running:
            self._running.withdraw()
        refuses = reading.negated or reading.intent in (GuidanceIntent.NO, GuidanceIntent.FOLLOW)
        self._climb.quiet_until_s = math.inf if refuses else now + self.ladder.words.expire_s
        self._end_words(now, "the plan is given up" if running else "nothing is begun")

    def _ask_back(self, words: Guidance, now: float) -> None:
        """Unclear words move nothing; the passenger is asked once what was meant."""
        self._dismiss(words, now, "not understood")
        if not self._asked_back:
            self._asked_back = True
            reader = self._listening.reader
            self._tell(now, EventKind.ASKED_BACK, reader.why if isinstance(reader, NoReader) else ASK_BACK)

    def _dismiss(self, words: Guidance, now: float, how: str) -> None:
        self._tell(now, EventKind.GUIDANCE_ENDED, f'"{words.text}": {how}')

    def _end_words(self, now: float, how: str) -> None:
        words = self._words.now
        assert words is not None
        self._dismiss(words, now, how)
        self._words.now = None
        self._failures.forget_attempts()

    # ---- questions

    def _question(
        self,
        now: float,
        kind: QuestionKind,
        to: Person,
        text: str,
        *,
        within_s: float | None = None,
        judged: Judged | None = None,
    ) -> None:
        question = self._desk.open(
            Question(
                id=self._desk.next_id(),
                time_s=self._stack_s(now),
                kind=kind,
                to=to,
                text=text,
                plan=judged.plan if judged else None,
                needs=judged.need.what if judged and judged.need else (),
                within_s=within_s,
            ),
            now,
        )
        self._tell(now, EventKind.ASKED, text, question=question)

    def _ask_for_yes(self, judged: Judged, answer: Answer, now: float) -> None:
        """A plan that would be accepted if a person agreed."""
        assert judged.need is not None
        self._for_approval = answer
        what = " and ".join(name.replace("_", " ") for name in judged.need.what)
        text = f"{answer.decision.rationale}. May I? It needs your yes for: {what}"
        within = self.ladder.asking.approval_within_s
        self._question(now, QuestionKind.APPROVAL, judged.need.to, text, within_s=within, judged=judged)

    def _unanswered(self, question: Question, now: float) -> None:
        """Nobody answered in time."""
        self._desk.withdraw()
        self._tell(now, EventKind.CANCELLED, f"no answer from the {question.to}", question=question)
        if question.kind is QuestionKind.ADVICE:
            self._climb_on(now)
        else:
            self._failed(now)

    def _agreed(self, question: Question) -> None:
        """Keep a yes for this plan, for as long as the intervention lasts."""
        assert question.plan is not None
        key = signature(question.plan)
        self._approved[key] = granted(self._approved.get(key, NOBODY), question.to, question.needs)

    def _denied(self, question: Question, now: float) -> None:
        assert question.plan is not None
        self._failures.denied(question.plan)
        self._failures.note(question.plan, AttemptEnd.DENIED, self._stack_s(now))
        self._failed(now)

    # ---- help from outside

    def _halt(self, move: Assist, now: float) -> Directive:
        """The minimal risk condition, and the call for help."""
        scene = self._asking.scene
        why = why_stopped(scene, self._failures.attempts)
        self._blocked_at_stop = still_blocked(scene)
        self._stop = SafeStop(reason=why)
        self._tell(now, EventKind.STOPPED, f"minimal risk condition: {why}")
        self._call_for_help(now, why)
        self._climb.pause(now + move.look_every_s)
        return self._stop

    def _not_held(self, move: Assist, now: float) -> Directive:
        """No place to stand, and no way to one: call for help, and leave the stack free to drive off."""
        why = why_stopped(self._asking.scene, self._failures.attempts)
        if self._desk.pending is None:
            self._call_for_help(now, f"it stands where nobody should: {why}")
        self._climb.pause(now + move.look_every_s)
        return CONTINUE

    def _call_for_help(self, now: float, why: str) -> None:
        self._question(now, QuestionKind.ASSISTANCE, "operator", f"The vehicle needs help: {why}")

    @property
    def _resumes(self) -> Resume | None:
        """What ends the stop, on the last rung."""
        return self._climb.move.resume if isinstance(self._climb.move, Assist) else None

    def _release(self, now: float, why: str) -> None:
        """End the stop; the rung stays until the hand-back is verified."""
        move = self._climb.move
        self._stop, self._tried_aside = None, False
        self._desk.withdraw()
        self._tell(now, EventKind.RELEASED, why)
        self._climb.pause(now + (move.look_every_s if isinstance(move, Assist) else 0.0))

    def _free_again(self) -> bool:
        """Has what stood in the way when the vehicle stopped gone?"""
        by_itself = self._resumes in (Resume.CLEAR, Resume.PLAN)
        return self._stop is not None and by_itself and self._blocked_at_stop and not still_blocked(self._asking.scene)

    def _helped_out(self, yes: bool, now: float) -> Directive:
        """The operator's answer to the call."""
        if yes:
            self._release(now, "the operator lets it try again")
            self._climb.reset()
        return self._stop or CONTINUE
