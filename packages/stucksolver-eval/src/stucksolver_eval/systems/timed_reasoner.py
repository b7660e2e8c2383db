"""Measures the cost and the reliability of a system's reasoners."""

from __future__ import annotations

import time

from stucksolver.reasoners import Reasoner, ReasonerError
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
        self._trace: ReasonerTrace | None = None
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
        self._trace = None
        try:
            answer = self._inner.decide(request)
            self._asked, self._trace = self._asked + 1, answer.trace
            return answer
        except BudgetExceededError:
            raise
        except ReasonerError as error:
            self._trace = error.trace
            # A query that was canceled because the situation cleared does not count for or against the reasoner.
            if not self._withdrawn:
                self._asked, self._unanswered, self._why = self._asked + 1, self._unanswered + 1, str(error)
            raise
        finally:
            self.took_s = time.perf_counter() - began

    @property
    def tokens(self) -> int:
        """Input and output tokens of the last answer."""
        trace = self._trace
        return 0 if trace is None else (trace.input_tokens or 0) + (trace.output_tokens or 0)

    @property
    def usd(self) -> float | None:
        """Cost of the last answer (US dollars); None if it is unknown or free."""
        return None if self._trace is None else self._trace.usd

    @property
    def reliability(self) -> Reliability | None:
        """Reliability of the reasoner; None for a reasoner without an external service."""
        if not self._asked or not isinstance(self._inner, SupportsPreflight):
            return None
        return Reliability(reasoner=self.name, asked=self._asked, unanswered=self._unanswered, why=self._why)

    def cancel(self) -> None:
        """Cancel the wrapped reasoner, if it supports that."""
        self._withdrawn = True
        if isinstance(self._inner, Cancellable):
            self._inner.cancel()
