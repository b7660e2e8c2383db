"""Registers language models as reasoners, under the names `openai:MODEL…` and `recorded:FOLDER`."""

from __future__ import annotations

from pathlib import Path

from stucksolver.privacy.url_redaction import shown_address, without_login
from stucksolver.reasoners.reasoner import Reasoner
from stucksolver.reasoners.registry import ReasonerKind, ReasonerNameError, help_text
from stucksolver_language.llm import LanguageModelReasoner
from stucksolver_language.llm.exchanges import RecordedChat, RecordingChat
from stucksolver_language.llm.model_families import family_of
from stucksolver_language.llm.model_options import parse_options
from stucksolver_language.llm.openai_api import OpenAiChat

BLIND = "#pictures=off"


def _openai(rest: str, exchanges: Path | None) -> Reasoner:
    rest, login = without_login(rest)
    address, *options = rest.split("#")
    model, _, base_url = address.partition("@")
    if not model:
        raise ReasonerNameError(f"no model in name: openai:{shown_address(rest)}. Use {help_text()}")
    try:
        chat = OpenAiChat(model, base_url or None, parse_options(options), login)
        kept = chat if exchanges is None else RecordingChat(chat, exchanges)
        return LanguageModelReasoner(kept)
    except ValueError as error:
        raise ReasonerNameError(f"openai:{shown_address(rest)}: {error}") from error


def _recorded(rest: str, exchanges: Path | None) -> Reasoner:
    if not rest:
        raise ReasonerNameError(f"no folder in name: recorded:. Use {help_text()}")
    return LanguageModelReasoner(RecordedChat(Path(rest)))


def _sees(rest: str) -> bool:
    return BLIND not in rest and family_of(rest.partition("#")[0].partition("@")[0]).pictures


OPENAI = ReasonerKind("openai", "openai:MODEL[@BASE_URL][#OPTION=VALUE…]", _openai, _sees)
RECORDED = ReasonerKind("recorded", "recorded:FOLDER", _recorded, lambda rest: True)
