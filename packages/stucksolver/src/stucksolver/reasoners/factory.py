"""Creates reasoners from the names that commands and configuration files use."""

from __future__ import annotations

from pathlib import Path

from stucksolver.privacy.url_redaction import logins_in, redacted
from stucksolver.reasoners import custom, rules, search
from stucksolver.reasoners.fallback import FallbackReasoner
from stucksolver.reasoners.reasoner import Reasoner, ReasonerError, SupportsPreflight
from stucksolver.reasoners.registry import KINDS, ReasonerNameError, help_text, kind_of, load_plugins

CORE = (rules, search, custom)
"""Modules of the core, which register their kinds when they are imported. Plug-ins register theirs by entry point."""
# After the core, so that a plug-in cannot replace a built-in kind.
load_plugins()
HELP = help_text()
"""Help text with the names of all reasoners. It is complete only after the plug-ins are loaded."""


def make_reasoner(words: str, exchanges: Path | None = None) -> Reasoner:
    """Create a reasoner from its name, such as `rules` or `openai:MODEL`.

    Args:
        words: Name; several names, separated by commas, are queried in order.
        exchanges: Folder in which every request to a model and its answer is stored, if given.

    Raises:
        ReasonerNameError: The reasoner does not exist, or cannot be created.
        ExchangesError: The folder cannot be used.
    """
    if any("," in login for login in logins_in(words)):
        raise ReasonerNameError("an address has a comma in its user name or password: write it as %2C")
    kinds = [kind_of(word.strip()) for word in words.split(",")]
    reasoners = [kind.make(rest, exchanges) for kind, rest in kinds]
    return reasoners[0] if len(reasoners) == 1 else FallbackReasoner(reasoners)


def sees(words: str) -> bool:
    """True if any of these reasoners uses the camera's images."""
    kinds = [word.strip().partition(":") for word in words.split(",")]
    return any(KINDS[name].sees(rest) for name, _, rest in kinds if name in KINDS)


def preflight(reasoner: Reasoner, name: str) -> tuple[str, ...]:
    """Check once that a reasoner can be used, and return its notes for the user, one line each.

    Raises:
        ReasonerNameError: The reasoner `name` cannot be used. The message has the reason and the remedy.
    """
    if not isinstance(reasoner, SupportsPreflight):
        return ()
    try:
        return reasoner.preflight()
    except ReasonerError as error:
        raise ReasonerNameError(f"{redacted(name)} cannot be used: {error}") from error


def unanswered_banner(asked: int, unanswered: int, name: str, most_frequent: str = "") -> str | None:
    """Return a warning if a reasoner has given no usable answer to most queries, or None."""
    if 2 * unanswered <= asked:
        return None
    why = f"; most often: {most_frequent}" if most_frequent else ""
    return (
        f"WARNING: {unanswered} of {asked} questions to {redacted(name)} had no usable answer; these results are "
        f"mostly those of the vehicle without it{why}"
    )
