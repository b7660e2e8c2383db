"""Reasoners: they propose plans, and the guard decides."""

from stucksolver.reasoners.reasoner import (
    PARSERS,
    Answer,
    Cancellable,
    Reasoner,
    ReasonerError,
    Request,
    Trace,
    parse_trace,
)
from stucksolver.reasoners.rules import RuleReasoner

__all__ = [
    "PARSERS",
    "Answer",
    "Cancellable",
    "Reasoner",
    "ReasonerError",
    "Request",
    "RuleReasoner",
    "Trace",
    "parse_trace",
]
