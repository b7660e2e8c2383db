"""Several reasoners in order: the next is asked when one has no answer."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence

from stucksolver.decision import Decision
from stucksolver.reason.reasoner import (
    AsksGuard,
    Cancellable,
    KeepsDeadline,
    PlanCheck,
    Preflighted,
    Reasoner,
    ReasonerError,
    Trace,
    Traced,
)
from stucksolver.scene import Scene


class FallbackReasoner:
    """Asks the first; where it raises `ReasonerError`, the second, and so on. `last_trace` is of who answered."""

    def __init__(self, reasoners: Sequence[Reasoner]) -> None:
        if not reasoners:
            raise ValueError("a fallback needs at least one reasoner")
        self.reasoners = tuple(reasoners)
        self.name = ", then ".join(r.name for r in self.reasoners)
        self.last_trace: Trace | None = None
        self.failures: tuple[str, ...] = ()
        """Why those before the one who answered had no answer, at the last question."""
        self._limit_s: float | None = None
        self._asked: Reasoner | None = None
        self._cancelled = threading.Event()

    def decide(self, scene: Scene) -> Decision:
        self._cancelled.clear()
        self.failures = ()
        ends_at = None if self._limit_s is None else time.monotonic() + self._limit_s
        for number, reasoner in enumerate(self.reasoners):
            self._asked = reasoner
            if ends_at is not None:
                self._share(ends_at, number)
            try:
                return reasoner.decide(scene)
            except ReasonerError as error:
                self.failures = (*self.failures, f"{reasoner.name}: {error}")
                if self._cancelled.is_set():
                    break
            finally:
                self.last_trace = reasoner.last_trace if isinstance(reasoner, Traced) else None
        raise ReasonerError("; ".join(self.failures))

    def _share(self, ends_at: float, number: int) -> None:
        """The one whose turn it is gets as much of the time that is left as each slow one after it."""
        slow = [one for one in self.reasoners[number:] if isinstance(one, KeepsDeadline)]
        reasoner = self.reasoners[number]
        if isinstance(reasoner, KeepsDeadline):
            reasoner.answer_within(max(ends_at - time.monotonic(), 0.0) / len(slow))

    def answer_within(self, limit_s: float) -> None:
        self._limit_s = limit_s

    def preflight(self) -> tuple[str, ...]:
        checked = [one for one in self.reasoners if isinstance(one, Preflighted)]
        return tuple(note for one in checked for note in one.preflight())

    def check_with(self, check: PlanCheck | None) -> None:
        for reasoner in self.reasoners:
            if isinstance(reasoner, AsksGuard):
                reasoner.check_with(check)

    def cancel(self) -> None:
        self._cancelled.set()
        asked: object = self._asked
        if isinstance(asked, Cancellable):
            asked.cancel()
