"""Asks a reasoner off the control loop: one question at a time, in a thread of its own, with a deadline."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future

from stucksolver.reason import Cancellable, Reasoner, ReasonerError
from stucksolver.scene import Scene
from stucksolver.solver.clock import WAIT_LIMIT_S, Clock, Query
from stucksolver.solver.panel import Answer

Consult = Callable[[Scene], Answer]


class Thinking:
    """Holds the question under way, if one is."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.scene: Scene | None = None
        """What the last question was about."""
        self._reasoner: Reasoner | None = None
        self._deadline_s = 0.0
        self._query: Query | None = None
        self._answer: Future[Answer] | None = None
        self._running: dict[int, Future[Answer]] = {}
        """By reasoner: calls that have not come back, dropped ones too. One reasoner is never called twice at once."""

    @property
    def busy(self) -> bool:
        return self._answer is not None

    def ask(self, reasoner: Reasoner, consult: Consult, scene: Scene, now_s: float, deadline_s: float) -> None:
        """Start a question; none may be under way. Raises `ReasonerError` while the reasoner is at an older one."""
        assert self._answer is None, "one question at a time"
        before = self._running.get(id(reasoner))
        if before is not None and not before.done():
            raise ReasonerError(f"{reasoner.name} is still busy with an older question")
        self.scene, self._reasoner, self._deadline_s = scene, reasoner, deadline_s
        # A simulated world waits for as long as the reasoner may take, and a little more, so that it can say why not.
        self._query = query = Query(now_s, time.monotonic(), wait_s=max(WAIT_LIMIT_S, deadline_s + 5.0))
        self._answer = self._running[id(reasoner)] = answer = Future[Answer]()
        # A daemon, so that a reasoner that never answers does not keep the process from ending.
        threading.Thread(
            target=_think, args=(consult, scene, query, answer), name="stucksolver-reasoner", daemon=True
        ).start()

    def poll(self, now_s: float) -> Answer | None:
        """The answer when the clock delivers it. Raises `ReasonerError`, whatever went wrong in the reasoner."""
        if self._answer is None or self._query is None or self._reasoner is None:
            return None
        name = self._reasoner.name
        self._query.ticks += 1
        if not self.clock.due(self._query, now_s, self._answer):
            if now_s - self._query.asked_s <= self._deadline_s:
                return None
            self.drop()
            raise ReasonerError(f"{name} gave no answer within {self._deadline_s:g} s")
        answer = self._answer
        if not answer.done():
            self.drop()
            raise ReasonerError(f"{name} hangs: no answer within {self._query.wait_s:g} s of wall time")
        self._answer = None
        error = answer.exception()
        if isinstance(error, ReasonerError):
            raise error
        if error is not None:
            raise ReasonerError(f"{name} failed: {type(error).__name__}: {error}") from error
        return answer.result()

    def drop(self) -> None:
        """Forget the question under way; a reasoner that can be told so is told that its answer is not wanted."""
        answer, self._answer = self._answer, None
        reasoner: object = self._reasoner
        if answer is None or answer.done() or not isinstance(reasoner, Cancellable):
            return
        with contextlib.suppress(Exception):  # whatever a reasoner does when it is told to stop
            reasoner.cancel()


def _think(consult: Consult, scene: Scene, query: Query, answer: Future[Answer]) -> None:
    try:
        result = consult(scene)
    except BaseException as error:  # noqa: BLE001 - kept for the taker, whatever a reasoner raises
        query.took_s = time.monotonic() - query.asked_wall_s
        answer.set_exception(error)
    else:
        query.took_s = time.monotonic() - query.asked_wall_s
        answer.set_result(result)
