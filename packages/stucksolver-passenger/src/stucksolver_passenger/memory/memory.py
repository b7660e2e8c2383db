"""`Memory`: the object that a stack adds. It receives events, writes in the background, and wraps a reasoner."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from stucksolver.plan import WaitLimits
from stucksolver.reasoners import Reasoner, SearchReasoner
from stucksolver.solver import Event
from stucksolver_passenger.memory.features import SceneFeatures
from stucksolver_passenger.memory.memory_reasoner import MemoryReasoner
from stucksolver_passenger.memory.observer import OutcomeObserver
from stucksolver_passenger.memory.store import MemoryFileError, SolutionStore
from stucksolver_passenger.memory.tried_solution import TriedSolution

Listener = Callable[[Event], None]


class Memory:
    """A memory in a file, for the vehicles of a process. Several processes may share the file.

    ```python
    with Memory(Path("memory.db")) as memory:
        solver = StuckSolver(stack.scene, reasoner=memory.before(), on_event=memory.ear("car-1"))
    ```

    It never blocks a control loop, and a fault of the file never stops a drive: `fault` contains the error. `now_s`
    returns the seconds since 1970.

    Raises:
        MemoryFileError: The file cannot be used at the start.
    """

    def __init__(self, path: Path, *, now_s: Callable[[], float] = time.time) -> None:
        self.store = SolutionStore(path)
        self.fault: MemoryFileError | None = None
        """The last error of the file; None if there is none."""
        self._now_s = now_s
        self._observers: list[OutcomeObserver] = []
        self._waiting: queue.Queue[TriedSolution | None] = queue.Queue()
        self._writer = threading.Thread(target=self._write, name="stucksolver-memory", daemon=True)
        self._writer.start()

    def before(self, inner: Reasoner | None = None, limits: WaitLimits | None = None) -> MemoryReasoner:
        """Return a reasoner that first proposes a solution that worked, and otherwise queries `inner`.

        Args:
            inner: The other reasoner; the built-in search if None.
            limits: Limits of legitimate waits. Pass the ladder's (`ladder.waits.limits()`) if it is not the
                default one.
        """
        return MemoryReasoner(inner or SearchReasoner(limits), self._remembered, limits)

    def ear(self, vehicle: str, further: Listener | None = None) -> Listener:
        """Return the listener for a vehicle's solver (`on_event`).

        Args:
            vehicle: Name of the vehicle.
            further: Receives the events after the memory.
        """
        observer = OutcomeObserver(vehicle[:40], self._waiting.put, self._now_s)
        self._observers.append(observer)

        def hear(event: Event) -> None:
            observer.hear(event)
            if further is not None:
                further(event)

        return hear

    def close(self) -> None:
        """End all drives: record open interventions and write everything."""
        for observer in self._observers:
            observer.close()
        self._observers.clear()
        if self._writer.is_alive():
            self._waiting.put(None)
            self._writer.join()

    def __enter__(self) -> Memory:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _remembered(self, scene: SceneFeatures) -> tuple[TriedSolution, ...]:
        """Return the entries for a scene, for reasoners outside the control loop.

        Includes all that ended before the query.
        """
        self._waiting.join()
        try:
            return tuple(stored.episode for stored in self.store.episodes(scene.obstacle))
        except MemoryFileError as error:
            # The memory is optional: without it the reasoner queries the next one.
            self.fault = error
            return ()

    def _write(self) -> None:
        """Write queued entries, in the writer's thread."""
        while True:
            episode = self._waiting.get()
            try:
                if episode is None:
                    return
                self.store.add(episode)
            except MemoryFileError as error:
                # The entry is lost, and the thread continues with the next one. `fault` reports the error.
                self.fault = error
            finally:
                self._waiting.task_done()
