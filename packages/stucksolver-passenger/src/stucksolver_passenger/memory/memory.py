"""`Memory`: the object that a stack switches on. It listens to events, writes in the background, and wraps a
reasoner.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from stucksolver.plan import WaitLimits
from stucksolver.reasoners import Reasoner, RuleReasoner
from stucksolver.solver import Event
from stucksolver_passenger.memory.features import SceneFeatures
from stucksolver_passenger.memory.memory_reasoner import MemoryReasoner
from stucksolver_passenger.memory.observer import OutcomeObserver
from stucksolver_passenger.memory.store import MemoryFileError, SolutionStore
from stucksolver_passenger.memory.tried_solution import TriedSolution

Listener = Callable[[Event], None]


class Memory:
    """A memory in a file, for the vehicles of a process. Several processes may share the file.

    ```python with Memory(Path("memory.db")) as memory:
        solver = StuckSolver(stack.scene, reasoner=memory.before(), on_event=memory.ear("car-1"))
    ```

    It never makes a control loop wait, and a fault of the file never stops a drive: `fault` says what is wrong. `now_s`
    returns the seconds since 1970.

    Raises:
        MemoryFileError: The file cannot be used at the start.
    """

    def __init__(self, path: Path, *, now_s: Callable[[], float] = time.time) -> None:
        self.store = SolutionStore(path)
        self.fault: MemoryFileError | None = None
        """The last problem with the file; None if there is none."""
        self._now_s = now_s
        self._observers: list[OutcomeObserver] = []
        self._waiting: queue.Queue[TriedSolution | None] = queue.Queue()
        self._writer = threading.Thread(target=self._write, name="stucksolver-memory", daemon=True)
        self._writer.start()

    def before(self, inner: Reasoner | None = None, limits: WaitLimits | None = None) -> MemoryReasoner:
        """Return a reasoner that first proposes what has worked, and otherwise asks `inner`.

        Args:
            inner: The other reasoner; the rules if None.
            limits: When waiting is right. Give the ladder's (`ladder.waits.limits()`) if it is not the default one.
        """
        return MemoryReasoner(inner or RuleReasoner(limits), self._remembered, limits)

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
        """End all drives: note what is still open and write everything."""
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
        """Called by reasoners outside the control loop. Includes everything that ended before the question."""
        self._waiting.join()
        try:
            return tuple(kept.episode for kept in self.store.episodes(scene.obstacle))
        except MemoryFileError as error:
            self.fault = error
            return ()

    def _write(self) -> None:
        """The body of the writer's thread."""
        while True:
            episode = self._waiting.get()
            try:
                if episode is None:
                    return
                self.store.add(episode)
            except MemoryFileError as error:
                self.fault = error
            finally:
                self._waiting.task_done()
