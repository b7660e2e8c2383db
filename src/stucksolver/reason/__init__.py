"""Reasoners: they propose plans, and the guard decides."""

from stucksolver.reason.reasoner import (
    PARSERS,
    Answer,
    Cancellable,
    Reasoner,
    ReasonerError,
    Request,
    Trace,
    parse_trace,
)
from stucksolver.reason.rules import RuleReasoner

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
