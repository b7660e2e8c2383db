"""Measures the cost and the reliability of a system's reasoners."""

from __future__ import annotations

import time

from stucksolver.reasoners import Reasoner, ReasonerError
from stucksolver.reasoners.fallback import FallbackReasoner
from stucksolver.reasoners.reasoner import (
    Cancellable,
    ReasonerAnswer,
    ReasonerRequest,
    ReasonerTrace,
    SupportsPreflight,
)
from stucksolver_eval.results.outcome import Reliability
from stucksolver_language.llm import BudgetExceededError


class TimedReasoner:
    """Measures the duration of each answer, and its tokens if the reasoner reports them."""

    def __init__(self, inner: Reasoner) -> None:
        self._inner = inner
        self._asked = self._unanswered = 0
        self._why = ""
        self._withdrawn = False
        self._spent: tuple[ReasonerTrace, ...] = ()
        self._queries = self._tokens = 0
        self._usd: float | None = 0.0
        self._latencies_s: list[float] = []
        self.answered_by = ""
        """Name of the reasoner that gave the last answer: in a chain, that of one of them."""
        self.took_s = 0.0
        """Wall time of the last answer (s)."""

    @property
    def name(self) -> str:
        """Name of the wrapped reasoner."""
        return self._inner.name

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Query the wrapped reasoner and measure the time."""
        began = time.perf_counter()
        self._withdrawn = False
        self._spent, self.answered_by = (), ""
        last: ReasonerTrace | None = None
        try:
            answer = self._inner.decide(request)
            self._asked, self.answered_by, last = self._asked + 1, answer.reasoner, answer.trace
            return answer
        except ReasonerError as error:
            last = error.trace
            # A query that was canceled because the situation cleared does not count for or against the reasoner, and
            # neither does one that was not sent.
            if not self._withdrawn and not isinstance(error, BudgetExceededError):
                self._asked, self._unanswered, self._why = self._asked + 1, self._unanswered + 1, str(error)
            raise
        finally:
            self.took_s = time.perf_counter() - began
            before = self._inner.failed_traces if isinstance(self._inner, FallbackReasoner) else ()
            self._count((*before, *(() if last is None else (last,))))

    def _count(self, traces: tuple[ReasonerTrace, ...]) -> None:
        """Add what one query spent at language models. Other reasoners state no tokens."""
        self._spent = tuple(trace for trace in traces if trace.input_tokens is not None)
        for trace in self._spent:
            self._queries += 1
            self._tokens += _tokens(trace)
            self._usd = None if self._usd is None or trace.usd is None else self._usd + trace.usd
            self._latencies_s.append(self.took_s if trace.seconds is None else trace.seconds)

    @property
    def tokens(self) -> int:
        """Input and output tokens of the last query."""
        return sum(map(_tokens, self._spent))

    @property
    def usd(self) -> float | None:
        """Cost of the last query (US dollars); None if it is unknown or free."""
        known = [trace.usd for trace in self._spent if trace.usd is not None]
        return sum(known) if known else None

    @property
    def reliability(self) -> Reliability | None:
        """Reliability and cost of the reasoner; None for a reasoner without an external service."""
        if not (self._asked or self._queries) or not isinstance(self._inner, SupportsPreflight):
            return None
        return Reliability(
            reasoner=self.name,
            asked=self._asked,
            unanswered=self._unanswered,
            why=self._why,
            queries=self._queries,
            tokens=self._tokens,
            usd=self._usd if self._queries else None,
            latencies_s=tuple(round(took_s, 4) for took_s in self._latencies_s),
        )

    def cancel(self) -> None:
        """Cancel the wrapped reasoner, if it supports that."""
        self._withdrawn = True
        if isinstance(self._inner, Cancellable):
            self._inner.cancel()


def _tokens(trace: ReasonerTrace) -> int:
    return (trace.input_tokens or 0) + (trace.output_tokens or 0)
