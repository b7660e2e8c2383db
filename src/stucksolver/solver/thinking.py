"""Asks a reasoner off the control loop: one question at a time, in a worker of its own."""

from __future__ import annotations

import time
from concurrent.futures import Future, ThreadPoolExecutor

from stucksolver.decision import Decision
from stucksolver.reason import Reasoner, ReasonerError
from stucksolver.scene import Scene
from stucksolver.solver.clock import Clock, Query


class Thinking:
    """Holds the question under way, if one is."""

    def __init__(self, reasoner: Reasoner, clock: Clock) -> None:
        self.reasoner = reasoner
        self.clock = clock
        self.scene: Scene | None = None
        self._worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="stucksolver-reasoner")
        self._query: Query | None = None
        self._answer: Future[Decision] | None = None

    @property
    def busy(self) -> bool:
        return self._answer is not None

    def ask(self, scene: Scene) -> None:
        """Start a question. One must not be under way."""
        assert self._answer is None, "one question at a time"
        self.scene = scene
        query = self._query = Query(scene.time_s, time.monotonic())
        self._answer = self._worker.submit(self.reasoner.decide, scene)
        self._answer.add_done_callback(lambda _: setattr(query, "took_s", time.monotonic() - query.asked_wall_s))

    def poll(self, now_s: float) -> Decision | None:
        """The answer when the clock delivers it. Raises `ReasonerError`, whatever went wrong in the reasoner."""
        if self._answer is None or self._query is None:
            return None
        self._query.ticks += 1
        if not self.clock.due(self._query, now_s, self._answer):
            return None
        answer, self._answer = self._answer, None
        error = answer.exception()
        if isinstance(error, ReasonerError):
            raise error
        if error is not None:
            raise ReasonerError(f"{self.reasoner.name} failed: {type(error).__name__}: {error}") from error
        decision = answer.result()
        if not isinstance(decision, Decision):
            raise ReasonerError(f"{self.reasoner.name} answered with a {type(decision).__name__}, not a Decision")
        return decision

    def drop(self) -> None:
        """Forget the question under way; its answer is not wanted any more."""
        if self._answer is not None:
            self._answer.cancel()
        self._answer = None

    def close(self) -> None:
        """End the worker. A question still under way is not waited for."""
        self.drop()
        self._worker.shutdown(wait=False, cancel_futures=True)
