"""Several reasoners in order: the next is asked when one has no answer."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from stucksolver.decision import Decision
from stucksolver.reason.reasoner import AsksGuard, Cancellable, PlanCheck, Reasoner, ReasonerError, Trace, Traced
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
        self._asked: Reasoner | None = None
        self._cancelled = threading.Event()

    def decide(self, scene: Scene) -> Decision:
        self._cancelled.clear()
        self.failures = ()
        for reasoner in self.reasoners:
            self._asked = reasoner
            try:
                return reasoner.decide(scene)
            except ReasonerError as error:
                self.failures = (*self.failures, f"{reasoner.name}: {error}")
                if self._cancelled.is_set():
                    break
            finally:
                self.last_trace = reasoner.last_trace if isinstance(reasoner, Traced) else None
        raise ReasonerError("; ".join(self.failures))

    def check_with(self, check: PlanCheck | None) -> None:
        for reasoner in self.reasoners:
            if isinstance(reasoner, AsksGuard):
                reasoner.check_with(check)

    def cancel(self) -> None:
        self._cancelled.set()
        asked: object = self._asked
        if isinstance(asked, Cancellable):
            asked.cancel()
