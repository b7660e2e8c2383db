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
"""Longest time to wait for the writing thread at the end (s). Ours."""
RUN_ENDED = "the run ended during this intervention"
"""End of a record whose intervention was still open at the end of the run."""


class Recorder:
    """Step listener that writes records: `StuckSolver(record=Recorder(folder))`. Legitimate waits leave no file.

    Differences are computed in the control loop. A separate thread converts and writes the lines. If that fails (a full
    disk), the lines before stay complete, and the next call raises `RecordError`. The solver then reports the error
    once and drives on without a record. As a context manager it closes after a run that ended, and breaks off after one
    that raised. After that, `error` is None if everything was written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.files: list[Path] = []
        """Files that have been begun."""
        self.error: RecordError | None = None
        self._facts: SolverInfo | None = None
        self._before: list[TransitionStep] = []
        """Steps held until it is certain that this is an intervention."""
        self._directive: Directive | None = None
        self._record_file: RecordFile | None = None
        self._work: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._write, name="stucksolver-record", daemon=True)
        self._thread.start()

    # ---- called by the solver

    def begin(self, facts: SolverInfo) -> None:
        """Store the setup of the solver, which begins every record."""
        self._facts = facts

    def step(self, step: TransitionStep) -> None:
        """Write a step, unless it had no effect."""
        if not step.outputs and step.directive is self._directive and step.after == step.before:
            # The step had no effect, and no later step depends on it.
            return
        self._directive = step.directive
        if self._record_file is not None:
            self._put(step)
        elif not self._waits(step):
            self._open()
        closed = [item for item in step.outputs if isinstance(item, Event) and item.kind is EventKind.CLOSED]
        if closed:
            self._finish(closed[-1].text)

    def fault(self, event: Event) -> None:
        """Write a fault into the open record, if there is one."""
        if self._record_file is not None:
            self._put(event)

    def close(self) -> None:
        """End the run normally: write the rest. The last line of an open intervention reports the end of the run."""
        self._finish(RUN_ENDED)
        self._leave()

    def break_off(self) -> None:
        """End a failed run: write the rest. An open intervention gets no last line."""
        record_file, self._record_file = self._record_file, None
        if record_file is not None:
            self._work.put(record_file.leave)
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
        """Hold a step while it is uncertain that this is an intervention. Each first query starts a new list."""
        before = step.before
        queries = any(isinstance(item, Event) and item.kind is EventKind.TRIGGERED for item in step.outputs)
        if queries and before.intervention is None and isinstance(before.activity, Monitoring):
            self._before.clear()
        self._before.append(step)
        return step.after.intervention is None

    def _open(self) -> None:
        assert self._facts is not None, "the solver calls `begin` first"
        record_file = self._record_file = RecordFile(self.folder, self._facts, self._before[0].before)
        self._work.put(lambda: self.files.append(record_file.open()))
        for step in self._before:
            self._put(step)
        self._before.clear()

    def _put(self, entry: TransitionStep | Event) -> None:
        if self.error is not None:
            raise self.error
        record_file = self._record_file
        if record_file is not None:
            lines = record_file.compact(entry)
            self._work.put(lambda: record_file.write(lines))

    def _finish(self, how: str) -> None:
        record_file, self._record_file = self._record_file, None
        if record_file is not None:
            self._work.put(lambda: record_file.end(how))

    def _leave(self) -> None:
        self._work.put(None)
        self._thread.join(LEAVE_S)
        if self._thread.is_alive() and self.error is None:
            self.error = RecordError(f"the record in {self.folder} was not written within {LEAVE_S:g} s")

    def _write(self) -> None:
        """Run the thread: write until the queue ends. After a failure, write nothing more.

        It keeps taking jobs after a failure, so that the control loop never waits and the thread can end.
        """
        while (job := self._work.get()) is not None:
            if self.error is not None:
                continue
            try:
                job()
            except RecordError as error:
                self.error = error
            except (OSError, ValueError, TypeError) as error:
                self.error = RecordError(f"cannot write the record in {self.folder}: {error}")
