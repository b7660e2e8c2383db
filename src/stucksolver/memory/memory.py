"""`Memory`: what a stack switches on. It listens, writes beside the control loop, and stands before a reasoner."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from stucksolver.decision import WaitLimits
from stucksolver.memory.episode import Episode
from stucksolver.memory.features import SceneFeatures
from stucksolver.memory.observer import Observer
from stucksolver.memory.reasoner import RememberingReasoner
from stucksolver.memory.store import EpisodeStore, MemoryFileError
from stucksolver.reason import Reasoner, RuleReasoner
from stucksolver.solver import Event

Listener = Callable[[Event], None]


class Memory:
    """A memory in a file, for the vehicles of a process; several processes may share the file.

    ```python
    with Memory(Path("memory.db")) as memory:
        solver = StuckSolver(stack.scene, reasoner=memory.before(), on_event=memory.ear("car-1"))
    ```

    Nothing that it does makes a control loop wait, and no fault of the file stops a drive: `fault` says what is wrong.
    `now_s`: seconds since 1970. Raises `MemoryFileError` where the file cannot be used at the start.
    """

    def __init__(self, path: Path, *, now_s: Callable[[], float] = time.time) -> None:
        self.store = EpisodeStore(path)
        self.fault: MemoryFileError | None = None
        """What went wrong with the file last; None while all is well."""
        self._now_s = now_s
        self._observers: list[Observer] = []
        self._waiting: queue.Queue[Episode | None] = queue.Queue()
        self._writer = threading.Thread(target=self._write, name="stucksolver-memory", daemon=True)
        self._writer.start()

    def before(self, inner: Reasoner | None = None, limits: WaitLimits | None = None) -> RememberingReasoner:
        """A reasoner that proposes first what has worked, and else asks `inner`: the rules where none is given.

        `limits`: when waiting is right; those of the ladder (`ladder.waits.limits()`), where that is not our own.
        """
        return RememberingReasoner(inner or RuleReasoner(limits), self._remembered, limits)

    def ear(self, vehicle: str, further: Listener | None = None) -> Listener:
        """What a vehicle's solver is to tell its events to (`on_event`); `further` hears them after the memory."""
        observer = Observer(vehicle[:40], self._waiting.put, self._now_s)
        self._observers.append(observer)

        def hear(event: Event) -> None:
            observer.hear(event)
            if further is not None:
                further(event)

        return hear

    def close(self) -> None:
        """The drives are over: what is still open is noted, and everything is written."""
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

    def _remembered(self, scene: SceneFeatures) -> tuple[Episode, ...]:
        """Called by reasoners, off the control loop. What was over before the question counts."""
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
