"""`StuckSolver`: the object that a driving stack owns. It watches, asks, checks, and tells what to do."""

from __future__ import annotations

import math
from collections.abc import Callable

from stucksolver.decision import CONTINUE, Directive
from stucksolver.detect import DetectorSettings, Trigger
from stucksolver.ladder.moves import Person
from stucksolver.scene import MAX_WORDS, Status, Surroundings
from stucksolver.solver.deliberation import Deliberation
from stucksolver.solver.events import EventKind
from stucksolver.solver.execution import STAND
from stucksolver.solver.questions import Question
from stucksolver.solver.senses import Read


class StuckSolver(Deliberation):
    """Three lines around a stack's own loop: make one, call `step` on every tick, perform what it returns.

    `scene` is called only when something may be wrong; `surroundings` (an argument of `step`) only then and while a
    plan runs; both may give None where they have nothing. Everything is called from the thread that calls `step`,
    except the reasoners. `guide`, `approve` and `deny` may be called from any thread.

    `ladder`: a profile's name, a file or a `Ladder`. `reasoner` takes the place of the rules; `models` are those that
    the ladder's other rungs name. `reader` reads a passenger's words: the shipped network, where its packages are
    installed. `record` is told all that is needed to derive everything again. With `observe_only`
    plans are judged but never performed, and nobody is asked. Raises `LadderError`.
    """

    # ---- called by the stack, a page, an operator's desk

    def step(self, status: Status, surroundings: Read | Callable[[], Surroundings]) -> Directive:
        """What the stack is to do at this tick. Returns at once (a lockstep clock waits for the reasoner)."""
        if not math.isfinite(status.time_s + status.speed_mps + status.progress_m):
            return self._without_status()
        status = self._timeline.follow(status)
        trigger = self._detector.update(status)
        if trigger is None and not self._engaged and self._said is None and self._timeline.jump_s is None:
            return CONTINUE
        directive = self._attend(status, trigger, surroundings)
        self._engaged = trigger is not None or self._open or self._progress.on or self._busy
        return directive

    @property
    def detector_settings(self) -> DetectorSettings:
        """What counts as immobilized."""
        return self._detector.settings

    def guide(self, text: str) -> None:
        """Take a passenger's words, at any time; they count from the next step on. Longer than `MAX_WORDS` is cut."""
        self._said = text[:MAX_WORDS]

    @property
    def pending_question(self) -> Question | None:
        """What a person is asked now."""
        return self._desk.pending

    def approve(self, question_id: str | None = None, by: Person = "passenger") -> None:
        """Say yes to the open question; it counts from the next step on. Raises `QuestionError`."""
        self._desk.reply(True, question_id, by)

    def deny(self, question_id: str | None = None, by: Person = "passenger") -> None:
        """Say no to the open question. Raises `QuestionError`."""
        self._desk.reply(False, question_id, by)

    def close(self) -> None:
        """Forget the question under way; nothing is asked any more unless `step` is called again."""
        self._asking.drop()

    def __enter__(self) -> StuckSolver:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # ---- the tick

    def _without_status(self) -> Directive:
        """Nothing is known of this tick: nothing begins, and a plan that runs stands still."""
        if self._timeline.now_s is not None:
            self._tell_fault(self._timeline.now_s, "the status has a value that is no number")
        return self._resting if self._running.execution is None else STAND

    def _attend(self, status: Status, trigger: Trigger | None, read: Read) -> Directive:
        """A tick on which something is, or may be, the matter."""
        now = status.time_s
        self._running.offset_s = self._timeline.offset_s
        if self._timeline.jump_s is not None:
            self._tell(now, EventKind.FAULT, f"the clock jumped by {self._timeline.jump_s:.2f} s")
        self._hear(now)
        self._watch(status, trigger)
        directive = self._act(status, trigger, read)
        if self._stays and directive == CONTINUE:
            directive = self._stay(status, read)
        self._tell_fault(now, self._running.senses.fault or self._asking.camera_fault)
        self._settle(status)
        return directive

    def _act(self, status: Status, trigger: Trigger | None, read: Read) -> Directive:
        now, reply = status.time_s, self._desk.take()
        if self._running.execution is not None:
            return self._perform(status, read)
        if reply is not None:
            return self._replied(reply, status, trigger, read)
        if trigger is None and self._words.now is None and self._stop is None and not self._still_there(status):
            self._cleared(now)
            return CONTINUE
        if self._asking.busy:
            return self._take_answer(status, trigger, read)
        return self._next(status, trigger, read)
