"""Reasoners propose; the guard disposes."""

from stucksolver.reason.reasoner import (
    PARSERS,
    Cancellable,
    Reasoner,
    ReasonerError,
    Trace,
    Traced,
    parse_trace,
)
from stucksolver.reason.rules import RuleReasoner

__all__ = [
    "PARSERS",
    "Cancellable",
    "Reasoner",
    "ReasonerError",
    "RuleReasoner",
    "Trace",
    "Traced",
    "parse_trace",
]
