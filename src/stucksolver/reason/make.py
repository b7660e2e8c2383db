"""Reasoners by the words that commands and configuration files use for them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from stucksolver.reason.fallback import FallbackReasoner
from stucksolver.reason.llm import LanguageModelReasoner
from stucksolver.reason.llm.chat import ChatModel
from stucksolver.reason.llm.exchanges import RecordedChat, RecordingChat
from stucksolver.reason.llm.openai_api import OpenAiChat
from stucksolver.reason.reasoner import Reasoner
from stucksolver.reason.rules import RuleReasoner

HELP = "rules, openai:MODEL[@BASE_URL], recorded:FOLDER, or several in order of trust, separated by commas"


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
    return any(word.strip().partition(":")[0] in MODELS for word in words.split(","))


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
    model, _, base_url = rest.partition("@")
    if not model:
        raise ReasonerNameError(f"openai:{rest} names no model: use {HELP}")
    return OpenAiChat(model, base_url or None)


MODELS: dict[str, Callable[[str], ChatModel]] = {
    "openai": _openai,
    "recorded": lambda rest: RecordedChat(Path(rest)),
}
"""Another vendor's API is one file and one line here."""
