"""The search reasoner: a general search through the guard in place of a rule for each case."""

from __future__ import annotations

from pathlib import Path

from stucksolver.reasoners.reasoner import Reasoner
from stucksolver.reasoners.registry import ReasonerKind, ReasonerNameError, help_text, register
from stucksolver.reasoners.search.search_reasoner import SearchReasoner


def _named(rest: str, exchanges: Path | None) -> Reasoner:
    if rest:
        raise ReasonerNameError(f"search takes no {rest!r}: use {help_text()}")
    return SearchReasoner()


register(ReasonerKind("search", "search", _named))
__all__ = ["SearchReasoner"]
