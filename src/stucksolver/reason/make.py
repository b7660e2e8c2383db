"""Reasoners by the words that commands and configuration files use for them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from stucksolver.reason.fallback import FallbackReasoner
from stucksolver.reason.llm import LanguageModelReasoner
from stucksolver.reason.llm.capabilities import parse_options
from stucksolver.reason.llm.chat import ChatModel
from stucksolver.reason.llm.exchanges import RecordedChat, RecordingChat
from stucksolver.reason.llm.openai_api import OpenAiChat
from stucksolver.reason.reasoner import Preflighted, Reasoner, ReasonerError
from stucksolver.reason.rules import RuleReasoner

HELP = (
    "rules, openai:MODEL[@BASE_URL][#OPTION=VALUE…], recorded:FOLDER, or several in order of trust, separated by commas"
)
BLIND = "#pictures=off"


class ReasonerNameError(ValueError):
    """No such reasoner; the message lists what there is."""


def make_reasoner(words: str, exchanges: Path | None = None) -> Reasoner:
    """A reasoner by its words. With `exchanges` every request to a model and its answer is kept in that folder.

    Raises `ReasonerNameError`, and `ExchangesError` for a folder that cannot be used.
    """
    reasoners = [_one(word.strip(), exchanges) for word in words.split(",")]
    return reasoners[0] if len(reasoners) == 1 else FallbackReasoner(reasoners)


def sees(words: str) -> bool:
    """Does any of these reasoners look at the camera's pictures?"""
    return any(
        one.partition(":")[0] in MODELS and "#pictures=off" not in one for one in map(str.strip, words.split(","))
    )


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


def _one(word: str, exchanges: Path | None) -> Reasoner:
    kind, _, rest = word.partition(":")
    if word == "rules":
        return RuleReasoner()
    if kind not in MODELS or not rest:
        raise ReasonerNameError(f"unknown reasoner {word!r}: use {HELP}")
    model = MODELS[kind](rest)
    if exchanges is not None and kind != "recorded":
        model = RecordingChat(model, exchanges)
    return LanguageModelReasoner(model)


def _openai(rest: str) -> ChatModel:
    address, *options = rest.split("#")
    model, _, base_url = address.partition("@")
    if not model:
        raise ReasonerNameError(f"openai:{rest} names no model: use {HELP}")
    try:
        return OpenAiChat(model, base_url or None, parse_options(options))
    except ValueError as error:
        raise ReasonerNameError(f"openai:{rest}: {error}") from error


MODELS: dict[str, Callable[[str], ChatModel]] = {
    "openai": _openai,
    "recorded": lambda rest: RecordedChat(Path(rest)),
}
"""Another vendor's API is one file and one line here."""
