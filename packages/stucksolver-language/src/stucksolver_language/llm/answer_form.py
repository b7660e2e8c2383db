"""The form in which a model answers: with a menu or without, and with a short or a long reasoning chain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from stucksolver.plan import CauseCode, GuidanceIntent, WaitReason
from stucksolver.reasoners.search.menu import LETTERS

Chain = Literal["short", "long"]
NONE = "none"
"""Choice of no plan. Other choices are the letters of a menu, and a list of behaviors: a plan of the model's own."""
CAN, CANNOT = "S2.1:", "S2.1:no:"
"""Prefixes of the conclusion about guidance: what is asked can be done, or cannot."""
HELD, IMMOBILIZED = "S2.4:", "S2.5:"
"""Prefixes of the conclusion without guidance: what holds the ego, or what immobilizes it."""
AT_DESTINATION, MOVING = "S2.2", "S2.3"
_REASONS = [r.value for r in WaitReason if r not in (WaitReason.AT_DESTINATION, WaitReason.NO_SAFE_WAY)]
_CAUSES = [cause.value for cause in CauseCode]
_INTENTS = [intent.value for intent in GuidanceIntent]
CONCLUSIONS = (
    AT_DESTINATION,
    MOVING,
    *(HELD + reason for reason in _REASONS),
    *(IMMOBILIZED + cause for cause in _CAUSES),
    *(CAN + intent for intent in _INTENTS),
    *(CANNOT + intent for intent in _INTENTS),
)
"""Codes of the second step of the short chain: the question that is answered with yes, and the reason."""
CONCLUSIONS_TEXT = (
    f"{AT_DESTINATION}, {MOVING}, {HELD}({'|'.join(_REASONS)}), {IMMOBILIZED}({'|'.join(_CAUSES)}), "
    f"{CAN}({'|'.join(_INTENTS)}) or {CANNOT} with the same"
)
"""The same codes in words."""


@dataclass(frozen=True)
class AnswerForm:
    """Form of an answer. It is the same in every query of a drive, so that the schema is."""

    menu: bool = True
    """List the plans that the search found, so that the model can answer with a letter."""
    chain: Chain = "short"
    """`short`: the choice first, then codes and a sentence. `long`: observation, analysis and decision of the paper."""

    @property
    def letters(self) -> tuple[str, ...]:
        """Letters that an answer may name."""
        return tuple(LETTERS) if self.menu else ()


USUAL_FORM = AnswerForm()


def form_of(parameters: Mapping[str, Any]) -> AnswerForm:
    """Return the form of a function's schema, as `tool_schema.decide_tool` writes it."""
    fields = parameters["properties"]
    if "choice" in fields:
        return AnswerForm(menu="A" in fields["choice"]["anyOf"][0]["enum"], chain="short")
    return AnswerForm(menu="choice" in fields["decision"]["properties"], chain="long")
