"""Reasoners propose; the guard disposes."""

from stucksolver.reason.reasoner import Reasoner, ReasonerError
from stucksolver.reason.rules import RuleReasoner

__all__ = ["Reasoner", "ReasonerError", "RuleReasoner"]
