"""Writes one file for each intervention, off the control loop."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from pathlib import Path

from stucksolver.record.chain import RecordError
from stucksolver.record.scroll import Scroll
from stucksolver.solver.events import Event, EventKind, Facts, Judgement, Tick

Entry = Event | Judgement | Tick
LEAVE_S = 10.0
RUN_ENDED = "the run ended with this intervention under way"


class Recorder:
    """A witness of the solver: `StuckSolver(record=Recorder(folder))`. Legitimate waits leave no file.

    What changed is found in the control loop; lines are made and written in a thread of its own. When that fails (a
    full disk), what has been written stays whole, and the next call raises `RecordError`: the solver tells of it once
    and drives on without a record. As a context manager it closes after a run that ended, and breaks off after one
    that raised. Look at `error` after that: it is None where everything was written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.files: list[Path] = []
        """Those begun so far."""
        self.error: RecordError | None = None
        self._facts: Facts | None = None
        self._before: list[Entry] = []
        """Said before it is clear that this is an intervention."""
        self._scroll: Scroll | None = None
        self._work: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._write, name="stucksolver-record", daemon=True)
        self._thread.start()

    # ---- called by the solver

    def begin(self, facts: Facts) -> None:
        self._facts = facts

    def event(self, event: Event) -> None:
        if self._scroll is None and event.intervention is None:
            if event.kind is EventKind.TRIGGERED:
                self._before.clear()
            self._before.append(event)
            return
        if self._scroll is None:
            self._open()
        self._put(event)
        if event.kind is EventKind.CLOSED:
            self._finish(event.text)

    def judgement(self, judgement: Judgement) -> None:
        if self._scroll is None:
            self._before.append(judgement)
        else:
            self._put(judgement)

    def tick(self, tick: Tick) -> None:
        self._put(tick)

    def close(self) -> None:
        """The run has ended: write what is left. The last line of an intervention under way says so."""
        self._finish(RUN_ENDED)
        self._leave()

    def break_off(self) -> None:
        """The run has failed: write what is left. An intervention under way gets no last line."""
        scroll, self._scroll = self._scroll, None
        if scroll is not None:
            self._work.put(scroll.leave)
        self._leave()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, failed: type[BaseException] | None, *_: object) -> None:
        if failed is None:
            self.close()
        else:
            self.break_off()

    # ---- within

    def _open(self) -> None:
        assert self._facts is not None, "the solver says first what it is made of"
        scroll = self._scroll = Scroll(self.folder, self._facts)
        self._work.put(lambda: self.files.append(scroll.open()))
        for entry in self._before:
            self._put(entry)
        self._before.clear()

    def _put(self, entry: Entry) -> None:
        if self.error is not None:
            raise self.error
        scroll = self._scroll
        if scroll is not None:
            lines = scroll.compact(entry)
            self._work.put(lambda: scroll.write(lines))

    def _finish(self, how: str) -> None:
        scroll, self._scroll = self._scroll, None
        if scroll is not None:
            self._work.put(lambda: scroll.end(how))

    def _leave(self) -> None:
        self._work.put(None)
        self._thread.join(LEAVE_S)
        if self._thread.is_alive() and self.error is None:
            self.error = RecordError(f"the record in {self.folder} was not written within {LEAVE_S:g} s")

    def _write(self) -> None:
        """The thread: do what is to be done until told to leave; after a failure nothing more is written."""
        while (job := self._work.get()) is not None:
            if self.error is not None:
                continue
            try:
                job()
            except RecordError as error:
                self.error = error
            except (OSError, ValueError, TypeError) as error:
                self.error = RecordError(f"cannot write the record in {self.folder}: {error}")
