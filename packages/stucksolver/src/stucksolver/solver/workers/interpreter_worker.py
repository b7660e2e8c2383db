"""Reads what people say outside the control loop, in the order in which it was said. A call to stop never waits.

Words queue: none are lost because others follow. A call to stop, or a warning of a collision, is recognized without the
network (`stucksolver.word_safeguards.restraint.alarm`) and counts on the same tick, whatever is still being read.
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
from stucksolver.word_safeguards.restraint import STOPPING, alarm, held, restrained

DEADLINE_S = 5.0
"""Words that are not read this long after they were said count as unclear. The first words wait for the reader to
load.
"""
MOST_WAITING = 32
"""So many utterances wait to be read (ours: a minute of fast talk). What comes on top is not read and holds the
vehicle.
"""
TOO_MANY = f"more than {MOST_WAITING} utterances wait to be read: the vehicle waits; say the last one again"


@dataclass
class _Utterance:
    """Words that wait to be read. `alarmed`: they have already held the vehicle."""

    words: Guidance
    said_s: float
    situation: str
    alarmed: bool
    query: Pending | None = None
    reading: Future[Interpretation] | None = None


class InterpreterWorker:
    """Words that are being read.

    Reading takes tens of milliseconds, so a clock that charges seconds for a language model's answers does not apply. A
    simulated world waits for the reading; a live stack never does.
    """

    def __init__(self, reader: Interpreter, clock: DeliveryClock) -> None:
        self.reader = reader
        self._clock: DeliveryClock = clock if isinstance(clock, WallClock | MeasuredLatency) else Lockstep()
        self._alarms: deque[GuidanceInput] = deque()
        self._waiting: deque[_Utterance] = deque()

    @property
    def busy(self) -> bool:
        """True while words are being read."""
        return bool(self._alarms or self._waiting)

    def take(self, text: str, time_s: float, now_s: float, situation: str) -> None:
        """Take new words, after those not read yet. `time_s` is the stack's time, `now_s` the solver's own."""
        words, called = Guidance(text=text, time_s=time_s), alarm(text)
        if called is not None:
            self._call(GuidanceInput(words.model_copy(update={"reading": called})))
        if len(self._waiting) < MOST_WAITING:
            self._waiting.append(_Utterance(words, now_s, situation, called is not None))
        elif called is None:
            self._call(GuidanceInput(words.model_copy(update={"reading": held(text)}), TOO_MANY))

    def poll(self, now_s: float) -> GuidanceInput | None:
        """Return the next words with their reading, once it is due; calls to stop come first."""
        if self._alarms:
            return self._alarms.popleft()
        while self._waiting:
            head = self._waiting[0]
            found = self._read(head, now_s)
            if found is None:
                return None
            self._waiting.popleft()
            reading = restrained(found[0], head.words.text)
            if not head.alarmed or reading.intent in STOPPING:
                return GuidanceInput(head.words.model_copy(update={"reading": reading}), found[1])
        return None

    def _call(self, heard: GuidanceInput) -> None:
        """Deliver a call to stop at the next poll. Of a flood, the first ones and every new danger are enough."""
        more = _is_danger(heard) and not any(map(_is_danger, self._alarms))
        if len(self._alarms) < MOST_WAITING or more:
            self._alarms.append(heard)

    def _read(self, head: _Utterance, now_s: float) -> tuple[Interpretation, str | None] | None:
        """Return the reading of the words that are next, with the fault; None while it is not due."""
        if head.query is None or head.reading is None:
            head.query, head.reading = Pending(now_s, time.monotonic()), Future[Interpretation]()
            work = (self.reader, head.words.text, head.situation, head.query, head.reading)
            threading.Thread(target=_read, args=work, name="stucksolver-words", daemon=True).start()
        head.query.ticks += 1
        if not self._clock.due(head.query, now_s, head.reading) and now_s - head.said_s <= DEADLINE_S:
            return None
        return _result(head.reading)


def _is_danger(heard: GuidanceInput) -> bool:
    return heard.words.reading is not None and heard.words.reading.danger


def _result(reading: Future[Interpretation]) -> tuple[Interpretation, str | None]:
    """Return the reading, or an unclear one with the fault."""
    nobody = NoInterpreter().read("", "")
    if not reading.done():
        return nobody, f"the reader of words gave no answer within {DEADLINE_S:g} s"
    error = reading.exception()
    if error is not None:
        return nobody, f"the reader of words failed: {error}"
    return reading.result(), None


def _read(reader: Interpreter, text: str, situation: str, query: Pending, reading: Future[Interpretation]) -> None:
    try:
        result = reader.read(text, situation)
    except BaseException as error:  # noqa: BLE001 - kept for the taker, whatever a reader raises
        reading.set_exception(error)
    else:
        reading.set_result(result)
    query.took_s = time.monotonic() - query.asked_wall_s
