"""Writes one file for each intervention, outside the control loop."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from pathlib import Path

from stucksolver.plan import Directive
from stucksolver.record.hash_chain import RecordError
from stucksolver.record.record_file import RecordFile
from stucksolver.solver.events import Event, EventKind
from stucksolver.solver.state_machine.state import Monitoring
from stucksolver.solver.step_listener import SolverInfo, TransitionStep

LEAVE_S = 10.0
RUN_ENDED = "the run ended during this intervention"


class Recorder:
    """A witness of the solver: `StuckSolver(record=Recorder(folder))`. Legitimate waits leave no file.

    Changes are found in the control loop; lines are made and written in a separate thread. If that fails (a full disk),
    what was written stays complete, and the next call raises `RecordError`. The solver then reports it once and drives
    on without a record. As a context manager it closes after a run that ended, and breaks off after one that raised.
    After that `error` is None if everything was written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.files: list[Path] = []
        """The files begun so far."""
        self.error: RecordError | None = None
        self._facts: SolverInfo | None = None
        self._before: list[TransitionStep] = []
        """Steps held until it is clear that this is an intervention."""
        self._directive: Directive | None = None
        self._scroll: RecordFile | None = None
        self._work: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._write, name="stucksolver-record", daemon=True)
        self._thread.start()

    # ---- called by the solver

    def begin(self, facts: SolverInfo) -> None:
        """Note the facts of the drive, which begin every record."""
        self._facts = facts

    def step(self, step: TransitionStep) -> None:
        """Write a step, unless it had no effect."""
        if not step.told and step.directive is self._directive and step.after == step.before:
            # It had no effect, and nothing later depends on it.
            return
        self._directive = step.directive
        if self._scroll is not None:
            self._put(step)
        elif not self._waits(step):
            self._open()
        closed = [item for item in step.told if isinstance(item, Event) and item.kind is EventKind.CLOSED]
        if closed:
            self._finish(closed[-1].text)

    def fault(self, event: Event) -> None:
        """Write a fault into the open record, if there is one."""
        if self._scroll is not None:
            self._put(event)

    def close(self) -> None:
        """End the run normally: write what is left. The last line of an open intervention says so."""
        self._finish(RUN_ENDED)
        self._leave()

    def break_off(self) -> None:
        """End a failed run: write what is left. An open intervention gets no last line."""
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

    # ---- private

    def _waits(self, step: TransitionStep) -> bool:
        """Hold a step if it is not yet clear that this is an intervention. Each question starts afresh."""
        before = step.before
        asks = any(isinstance(item, Event) and item.kind is EventKind.TRIGGERED for item in step.told)
        if asks and before.intervention is None and isinstance(before.activity, Monitoring):
            self._before.clear()
        self._before.append(step)
        return step.after.intervention is None

    def _open(self) -> None:
        assert self._facts is not None, "the solver says first what it is made of"
        scroll = self._scroll = RecordFile(self.folder, self._facts, self._before[0].before)
        self._work.put(lambda: self.files.append(scroll.open()))
        for step in self._before:
            self._put(step)
        self._before.clear()

    def _put(self, entry: TransitionStep | Event) -> None:
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
        """Run the thread: write until told to stop; after a failure, write nothing more."""
        while (job := self._work.get()) is not None:
            if self.error is not None:
                continue
            try:
                job()
            except RecordError as error:
                self.error = error
            except (OSError, ValueError, TypeError) as error:
                self.error = RecordError(f"cannot write the record in {self.folder}: {error}")
