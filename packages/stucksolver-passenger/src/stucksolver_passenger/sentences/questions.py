"""Questions to people."""

from __future__ import annotations

from stucksolver.plan.behaviors import REGISTRY
from stucksolver.solver import Question, QuestionKind
from stucksolver_passenger.sentences.plans import future_phrase

NEEDS: dict[str, str] = {
    "solid_line": "I would cross a solid line.",
    "emergency_scene": "I would pass a stopped emergency vehicle.",
    "school_bus": "I would pass a school bus.",
    "level_crossing": "I would cross a level crossing.",
    "flagger": "I would pass someone who directs the traffic.",
    "red_light": "I would drive through a red light.",
}
"""Approvals beyond the plan's own phrase: rules of the guard. A behavior has its own `approval_note`."""

ADVICE = "I cannot get any further by myself. What shall I do?"
ASSISTANCE = "I have stopped, and I need help. May I try again?"


def needed(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return a sentence for each approval that a yes includes.

    Raises:
        KeyError: There is no sentence for a name.
    """
    unknown = [name for name in names if name not in NEEDS and name not in REGISTRY]
    if unknown:
        raise KeyError(f"no sentence for: {', '.join(unknown)}. Add it to NEEDS")
    notes = (NEEDS[name] if name in NEEDS else REGISTRY[name].approval_note for name in names)
    return tuple(note for note in notes if note is not None)


def question_text(question: Question) -> str:
    """Return the question for people, made from its plan and codes. Its own text is the solver's."""
    if question.kind is QuestionKind.ADVICE:
        return ADVICE
    if question.kind is QuestionKind.ASSISTANCE or question.plan is None:
        return ASSISTANCE
    return " ".join((f"May I {future_phrase(question.plan)}?", *needed(question.needs)))
