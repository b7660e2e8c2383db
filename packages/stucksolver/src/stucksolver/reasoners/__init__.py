"""Reasoners propose plans, and the guard decides."""

from stucksolver.reasoners.reasoner import (
    PARSERS,
    Cancellable,
    Reasoner,
    ReasonerAnswer,
    ReasonerError,
    ReasonerRequest,
    ReasonerTrace,
    parse_trace,
)
from stucksolver.reasoners.search import SearchReasoner

__all__ = [
    "PARSERS",
    "Cancellable",
    "Reasoner",
    "ReasonerAnswer",
    "ReasonerError",
    "ReasonerRequest",
    "ReasonerTrace",
    "SearchReasoner",
    "parse_trace",
]
