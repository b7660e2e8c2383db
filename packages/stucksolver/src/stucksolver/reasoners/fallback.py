"""Queries several reasoners in order: the next one if one has no answer."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from dataclasses import replace

from stucksolver.reasoners.reasoner import (
    Cancellable,
    Reasoner,
    ReasonerAnswer,
    ReasonerError,
    ReasonerRequest,
    ReasonerTrace,
    SupportsPreflight,
)


class FallbackReasoner:
    """Chain of reasoners. If one raises `ReasonerError`, the next is queried. The answer has its reasoner's name."""

    def __init__(self, reasoners: Sequence[Reasoner]) -> None:
        if not reasoners:
            raise ValueError("a fallback needs at least one reasoner")
        self.reasoners = tuple(reasoners)
        self.name = ", then ".join(r.name for r in self.reasoners)
        self.failures: tuple[str, ...] = ()
        """Errors of the reasoners before the one that answered the last query."""
        self.failed_traces: tuple[ReasonerTrace, ...] = ()
        """Traces of these errors: what the last query cost before it was answered."""
        self._running: Reasoner | None = None
        self._cancelled = threading.Event()

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return the first answer of a reasoner.

        Raises:
            ReasonerError: No reasoner has an answer, or `cancel` was called.
        """
        self._cancelled.clear()
        self.failures, self.failed_traces = (), ()
        ends_at = None if request.deadline_s is None else time.monotonic() + request.deadline_s
        trace = None
        for number, reasoner in enumerate(self.reasoners):
            self._running = reasoner
            try:
                return reasoner.decide(self._share(request, ends_at, number))
            except ReasonerError as error:
                trace = error.trace or trace
                self.failed_traces += () if error.trace is None else (error.trace,)
                self.failures = (*self.failures, f"{reasoner.name}: {error}")
                if self._cancelled.is_set():
                    break
        failed = ReasonerError("; ".join(self.failures))
        failed.trace = trace
        self.failed_traces = self.failed_traces[:-1] if trace is not None else ()
        raise failed

    def _share(self, request: ReasonerRequest, ends_at: float | None, number: int) -> ReasonerRequest:
        """Return the request with an equal share of the remaining time for each cancellable reasoner from here on."""
        if ends_at is None:
            return request
        slow = [reasoner for reasoner in self.reasoners[number:] if isinstance(reasoner, Cancellable)]
        return replace(request, deadline_s=max(ends_at - time.monotonic(), 0.0) / max(len(slow), 1))

    def preflight(self) -> tuple[str, ...]:
        """Check the reasoners that can be checked before a drive, and return their notes.

        Raises:
            ReasonerError: One of them cannot be used.
        """
        checked = [reasoner for reasoner in self.reasoners if isinstance(reasoner, SupportsPreflight)]
        return tuple(note for item in checked for note in item.preflight())

    def cancel(self) -> None:
        """Cancel the running query; may be called from any thread."""
        self._cancelled.set()
        running: object = self._running
        if isinstance(running, Cancellable):
            running.cancel()
