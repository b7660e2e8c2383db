"""Checks that the answers to the questions of the chain support its conclusion."""

from __future__ import annotations

from collections.abc import Mapping

from stucksolver.plan import GuidanceIntent, WaitReason

HELD_BY = (WaitReason.LIGHT, WaitReason.STOP_SIGN, WaitReason.QUEUE, WaitReason.PEOPLE, WaitReason.YIELD)
"""Reasons to wait that belong to question S2.4."""


def wrong_chain(
    answers: Mapping[str, bool | None],
    *,
    immobilized: bool,
    wait: WaitReason | None,
    intent: GuidanceIntent | None,
    moves: bool,
) -> list[str]:
    """Return the contradictions, worded for the model.

    Args:
        answers: Yes, no or None (unknown), by question.
        immobilized: The conclusion.
        wait: The reason to wait, if any.
        intent: The intent of the passenger, if any.
        moves: True if a behavior of the plan moves the vehicle.
    """
    if "S2.1" in answers:
        return _with_guidance(answers["S2.1"], immobilized, intent, moves)
    wrong = _immobilized(answers, immobilized)
    held = answers["S2.4"] is True
    if held and wait in (None, WaitReason.AT_DESTINATION):
        wrong.append("S2.4 is yes: analysis.wait must say what holds the vehicle")
    if wait in HELD_BY and not held:
        wrong.append(f"analysis.wait is {wait.value}, but S2.4 is not yes")
    if wait is WaitReason.AT_DESTINATION and answers["S2.2"] is not True:
        wrong.append("analysis.wait is at_destination, but S2.2 is not yes")
    if held and moves:
        wrong.append("S2.4 is yes, so waiting is right: behaviors must be null, or stand still")
    return wrong


def _immobilized(answers: Mapping[str, bool | None], immobilized: bool) -> list[str]:
    """Return the contradictions with the conclusion S2.5: a yes to any of the other questions contradicts it."""
    if not immobilized:
        return ["S2.5 is yes, but analysis.immobilized is false"] if answers["S2.5"] is True else []
    against = [name for name in ("S2.2", "S2.3", "S2.4") if answers[name] is True]
    wrong = [f"{', '.join(against)} is yes, so analysis.immobilized must be false"] if against else []
    if answers["S2.5"] is not True:
        wrong.append("analysis.immobilized is true, but S2.5 is not yes")
    return wrong


def _with_guidance(
    can_be_done: bool | None, immobilized: bool, intent: GuidanceIntent | None, moves: bool
) -> list[str]:
    """Return the contradictions with guidance.

    A plan without immobilization must follow from the passenger's intent.
    """
    if not moves or immobilized:
        return []
    if can_be_done is not True:
        return ["S2.1 does not say that what is asked can be done: behaviors must be null, or stand still"]
    if intent is GuidanceIntent.UNCLEAR:
        return ["analysis.guidance_intent is unclear: behaviors must be null, or stand still"]
    return []
