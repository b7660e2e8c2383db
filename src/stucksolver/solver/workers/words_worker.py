"""Reads a passenger's words outside the control loop: only the newest, delivered by the clock."""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future

from stucksolver.scene import Guidance, Reading
from stucksolver.solver.machine.inputs import Heard
from stucksolver.solver.workers.clock import Clock, Lockstep, Measured, Pending, Wall
from stucksolver.words import NoReader, WordsReader

DEADLINE_S = 5.0
"""Words that are not read by then count as unclear. The first words wait for the reader to load."""


class WordsWorker:
    """Words that are being read.

    Reading takes tens of milliseconds, so a clock that charges seconds for a language model's answers does not apply. A
    simulated world waits for the reading; a live stack never does.
    """

    def __init__(self, reader: WordsReader, clock: Clock) -> None:
        self.reader = reader
        self._clock: Clock = clock if isinstance(clock, Wall | Measured) else Lockstep()
        self._said: Guidance | None = None
        self._query: Pending | None = None
        self._reading: Future[Reading] | None = None

    @property
    def busy(self) -> bool:
        """True while words are being read."""
        return self._said is not None

    def take(self, text: str, time_s: float, now_s: float, situation: str) -> None:
        """Take new words, replacing those not read yet. `time_s` is the stack's time, `now_s` the solver's own."""
        self._said, self._query = Guidance(text=text, time_s=time_s), Pending(now_s, time.monotonic())
        self._reading = reading = Future[Reading]()
        work = (self.reader, text, situation, self._query, reading)
        threading.Thread(target=_read, args=work, name="stucksolver-words", daemon=True).start()

    def poll(self, now_s: float) -> Heard | None:
        """Return the words with their reading, once it is due."""
        said, query, reading = self._said, self._query, self._reading
        if said is None or query is None or reading is None:
            return None
        query.ticks += 1
        if not self._clock.due(query, now_s, reading) and now_s - query.asked_s <= DEADLINE_S:
            return None
        self._said = None
        found, fault = _result(reading)
        return Heard(said.model_copy(update={"reading": found}), fault)


def _result(reading: Future[Reading]) -> tuple[Reading, str | None]:
    """Return the reading, or an unclear one with the fault."""
    nobody = NoReader().read("", "")
    if not reading.done():
        return nobody, f"the reader of words gave no answer within {DEADLINE_S:g} s"
    error = reading.exception()
    if error is not None:
        return nobody, f"the reader of words failed: {error}"
    return reading.result(), None


def _read(reader: WordsReader, text: str, situation: str, query: Pending, reading: Future[Reading]) -> None:
    try:
        result = reader.read(text, situation)
    except BaseException as error:  # noqa: BLE001 - kept for the taker, whatever a reader raises
        reading.set_exception(error)
    else:
        reading.set_result(result)
    query.took_s = time.monotonic() - query.asked_wall_s
