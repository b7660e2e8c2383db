"""Creates reasoners from the names that commands and configuration files use."""

from __future__ import annotations

from pathlib import Path

from stucksolver.privacy.url_redaction import logins_in, shown
from stucksolver.reasoners import custom, playback, rules
from stucksolver.reasoners.fallback import FallbackReasoner
from stucksolver.reasoners.reasoner import Reasoner, ReasonerError, SupportsPreflight
from stucksolver.reasoners.registry import KINDS, ReasonerNameError, help_text, kind_of, load_plugins

CORE = (rules, custom, playback)
"""Each module registers its kind when it is imported. Other distributions register theirs by entry point."""
load_plugins()
HELP = help_text()


def make_reasoner(words: str, exchanges: Path | None = None) -> Reasoner:
    """Create a reasoner from its name, such as `rules` or `openai:MODEL`.

    Args:
        words: The name; several, separated by commas, are asked in order.
        exchanges: Folder in which every request to a model and its answer is stored, if given.

    Raises:
        ReasonerNameError: There is no such reasoner, or it cannot be created.
        ExchangesError: The folder cannot be used.
    """
    if any("," in login for login in logins_in(words)):
        raise ReasonerNameError("an address has a comma in its user name or password: write it as %2C")
    found = [kind_of(word.strip()) for word in words.split(",")]
    reasoners = [kind.make(rest, exchanges) for kind, rest in found]
    return reasoners[0] if len(reasoners) == 1 else FallbackReasoner(reasoners)


def sees(words: str) -> bool:
    """True if any of these reasoners looks at the camera's images."""
    found = [word.strip().partition(":") for word in words.split(",")]
    return any(KINDS[name].sees(rest) for name, _, rest in found if name in KINDS)


def preflight(reasoner: Reasoner, name: str) -> tuple[str, ...]:
    """Check once that a reasoner can be used, and return what a person should know, one line each.

    Raises:
        ReasonerNameError: The reasoner `name` cannot be used. The message says why and what to do.
    """
    if not isinstance(reasoner, SupportsPreflight):
        return ()
    try:
        return reasoner.preflight()
    except ReasonerError as error:
        raise ReasonerNameError(f"{shown(name)} cannot be used: {error}") from error


def unanswered_banner(asked: int, unanswered: int, name: str, most_frequent: str = "") -> str | None:
    """Return a warning if most answers of a reasoner are missing in the results, or None."""
    if 2 * unanswered <= asked:
        return None
    why = f"; most often: {most_frequent}" if most_frequent else ""
    return (
        f"WARNING: {unanswered} of {asked} questions to {shown(name)} had no usable answer; these results are mostly "
        f"those of the vehicle without it{why}"
    )
