"""Reasoners by the words that commands and configuration files use for them."""

from __future__ import annotations

from pathlib import Path

from stucksolver.reason import own, rules
from stucksolver.reason.fallback import FallbackReasoner
from stucksolver.reason.llm import words
from stucksolver.reason.reasoner import Preflighted, Reasoner, ReasonerError
from stucksolver.reason.registry import KINDS, ReasonerNameError, help_text, kind_of

SHIPPED = (rules, words, own)
"""Each registers its kinds when it is imported. Another one is one file and one name here."""
HELP = help_text()


def make_reasoner(words: str, exchanges: Path | None = None) -> Reasoner:
    """A reasoner by its words. With `exchanges` every request to a model and its answer is kept in that folder.

    Raises `ReasonerNameError`, and `ExchangesError` for a folder that cannot be used.
    """
    found = [kind_of(word.strip()) for word in words.split(",")]
    reasoners = [kind.make(rest, exchanges) for kind, rest in found]
    return reasoners[0] if len(reasoners) == 1 else FallbackReasoner(reasoners)


def sees(words: str) -> bool:
    """Does any of these reasoners look at the camera's pictures?"""
    found = [word.strip().partition(":") for word in words.split(",")]
    return any(KINDS[name].sees(rest) for name, _, rest in found if name in KINDS)


def preflight(reasoner: Reasoner, name: str) -> tuple[str, ...]:
    """Asks it once whether it can be asked, and gives what a person should know, a line each.

    Raises `ReasonerNameError` that says which reasoner (`name`) cannot, why, and what to do.
    """
    if not isinstance(reasoner, Preflighted):
        return ()
    try:
        return reasoner.preflight()
    except ReasonerError as error:
        raise ReasonerNameError(f"{name} cannot be asked: {error}") from error


def unanswered_banner(asked: int, unanswered: int, name: str, most_frequent: str = "") -> str | None:
    """A line for results that say little of a reasoner, because most of its answers did not come; None for others."""
    if 2 * unanswered <= asked:
        return None
    why = f"; most often: {most_frequent}" if most_frequent else ""
    return (
        f"WARNING: {unanswered} of {asked} questions to {name} had no usable answer; these results are mostly those "
        f"of the vehicle without it{why}"
    )
