"""Asks a reasoner off the control loop: one question at a time, in a thread of its own."""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future

from stucksolver.decision import Decision
from stucksolver.reason import Reasoner, ReasonerError
from stucksolver.scene import Scene
from stucksolver.solver.clock import WAIT_LIMIT_S, Clock, Query

ANSWER_LIMIT_S = 10.0
"""A question is given up after this much time of the stack's clock, whoever may still be working on it."""


class Thinking:
    """Holds the question under way, if one is."""

    def __init__(self, reasoner: Reasoner, clock: Clock) -> None:
        self.reasoner = reasoner
        self.clock = clock
        self.scene: Scene | None = None
        self._query: Query | None = None
        self._answer: Future[Decision] | None = None

    @property
    def busy(self) -> bool:
        return self._answer is not None

    def ask(self, scene: Scene) -> None:
        """Start a question. One must not be under way."""
        assert self._answer is None, "one question at a time"
        self.scene = scene
        self._query = query = Query(scene.time_s, time.monotonic())
        self._answer = answer = Future[Decision]()
        # A daemon, so that a reasoner that never answers does not keep the process from ending.
        threading.Thread(
            target=self._think, args=(scene, query, answer), name="stucksolver-reasoner", daemon=True
        ).start()

    def _think(self, scene: Scene, query: Query, answer: Future[Decision]) -> None:
        try:
            decision = self.reasoner.decide(scene)
        except BaseException as error:  # noqa: BLE001 - kept for the taker, whatever a reasoner raises
            query.took_s = time.monotonic() - query.asked_wall_s
            answer.set_exception(error)
        else:
            query.took_s = time.monotonic() - query.asked_wall_s
            answer.set_result(decision)

    def poll(self, now_s: float) -> Decision | None:
        """The answer when the clock delivers it. Raises `ReasonerError`, whatever went wrong in the reasoner."""
        if self._answer is None or self._query is None:
            return None
        self._query.ticks += 1
        if not self.clock.due(self._query, now_s, self._answer):
            if self._answer.done() or now_s - self._query.asked_s <= ANSWER_LIMIT_S:
                return None
            self.drop()
            raise ReasonerError(f"{self.reasoner.name} gave no answer within {ANSWER_LIMIT_S:g} s")
        answer, self._answer = self._answer, None
        if not answer.done():
            raise ReasonerError(f"{self.reasoner.name} hangs: no answer within {WAIT_LIMIT_S:g} s of wall time")
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
        self._answer = None
