"""Interprets utterances outside the control loop, in their order. A call to stop never waits.

Utterances queue: none is lost because others follow. A call to stop, or a warning of a collision, is recognized without
the network (`stucksolver.word_safeguards.restraint.alarm`). It counts on the same tick, regardless of the queue.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from concurrent.futures import Future
from dataclasses import dataclass

from stucksolver.interpreter import Interpreter, NoInterpreter
from stucksolver.scene import Guidance, Interpretation
from stucksolver.solver.state_machine.inputs import GuidanceInput
from stucksolver.solver.workers.delivery_clock import DeliveryClock, Lockstep, MeasuredLatency, Pending, WallClock
from stucksolver.word_safeguards.restraint import STOPPING, alarm, holding_interpretation, restrained

DEADLINE_S = 5.0
"""Time after which an utterance without an interpretation counts as unclear (s). The first one waits for the
interpreter to load. Ours.
"""
MOST_WAITING = 32
"""Maximum length of the queue. Ours: a minute of fast talk. Further utterances only hold the vehicle."""
TOO_MANY = f"more than {MOST_WAITING} utterances wait to be interpreted: the vehicle waits; say the last one again"


@dataclass
class _Utterance:
    """Utterance in the queue. `alarmed`: True if it has already held the vehicle."""

    words: Guidance
    said_s: float
    situation: str
    alarmed: bool
    query: Pending | None = None
    reading: Future[Interpretation] | None = None


class InterpreterWorker:
    """Queue of utterances that are being interpreted.

    An interpretation takes tens of milliseconds, so a clock that charges seconds for a language model's answers does
    not apply. A simulated world waits for the interpretation; a live stack never does.
    """

    def __init__(self, reader: Interpreter, clock: DeliveryClock) -> None:
        self.reader = reader
        self._clock: DeliveryClock = clock if isinstance(clock, WallClock | MeasuredLatency) else Lockstep()
        self._alarms: deque[GuidanceInput] = deque()
        self._waiting: deque[_Utterance] = deque()

    @property
    def busy(self) -> bool:
        """True while utterances are being interpreted."""
        return bool(self._alarms or self._waiting)

    def take(self, text: str, time_s: float, now_s: float, situation: str) -> None:
        """Append an utterance to the queue. `time_s` is the stack's time, `now_s` the solver's own."""
        words, called = Guidance(text=text, time_s=time_s), alarm(text)
        if called is not None:
            self._call(GuidanceInput(words.model_copy(update={"reading": called})))
        if len(self._waiting) < MOST_WAITING:
            self._waiting.append(_Utterance(words, now_s, situation, called is not None))
        elif called is None:
            self._call(GuidanceInput(words.model_copy(update={"reading": holding_interpretation(text)}), TOO_MANY))

    def poll(self, now_s: float) -> GuidanceInput | None:
        """Return the next utterance with its interpretation when it is due; calls to stop come first."""
        if self._alarms:
            return self._alarms.popleft()
        while self._waiting:
            head = self._waiting[0]
            result = self._read(head, now_s)
            if result is None:
                return None
            self._waiting.popleft()
            reading = restrained(result[0], head.words.text)
            if not head.alarmed or reading.intent in STOPPING:
                return GuidanceInput(head.words.model_copy(update={"reading": reading}), result[1])
        return None

    def _call(self, guidance: GuidanceInput) -> None:
        """Deliver a call to stop at the next poll. In a flood, the first ones and every new danger are enough."""
        is_new_danger = _is_danger(guidance) and not any(map(_is_danger, self._alarms))
        if len(self._alarms) < MOST_WAITING or is_new_danger:
            self._alarms.append(guidance)

    def _read(self, head: _Utterance, now_s: float) -> tuple[Interpretation, str | None] | None:
        """Return the interpretation of the next utterance, with the fault; None while it is not due."""
        if head.query is None or head.reading is None:
            head.query, head.reading = Pending(now_s, time.monotonic()), Future[Interpretation]()
            work = (self.reader, head.words.text, head.situation, head.query, head.reading)
            threading.Thread(target=_read, args=work, name="stucksolver-words", daemon=True).start()
        head.query.ticks += 1
        if not self._clock.due(head.query, now_s, head.reading) and now_s - head.said_s <= DEADLINE_S:
            return None
        return _result(head.reading)


def _is_danger(guidance: GuidanceInput) -> bool:
    return guidance.words.reading is not None and guidance.words.reading.danger


def _result(reading: Future[Interpretation]) -> tuple[Interpretation, str | None]:
    """Return the interpretation, or an unclear one with the fault."""
    unclear = NoInterpreter().read("", "")
    if not reading.done():
        return unclear, f"the interpreter gave no answer within {DEADLINE_S:g} s"
    error = reading.exception()
    if error is not None:
        return unclear, f"the interpreter failed: {error}"
    return reading.result(), None


def _read(reader: Interpreter, text: str, situation: str, query: Pending, reading: Future[Interpretation]) -> None:
    try:
        result = reader.read(text, situation)
    except BaseException as error:  # noqa: BLE001 - any error is stored for the control loop, which reports it
        reading.set_exception(error)
    else:
        reading.set_result(result)
    query.took_s = time.monotonic() - query.asked_wall_s
