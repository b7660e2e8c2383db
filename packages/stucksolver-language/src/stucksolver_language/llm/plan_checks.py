"""Words in which the guard's verdict on a plan goes back to a model that asks before it decides."""

from __future__ import annotations

from stucksolver.plan.plan_text import assessment_text
from stucksolver.reasoners.reasoner import ReasonerRequest
from stucksolver.scene.mirror import with_sides_swapped
from stucksolver_language.llm.answer_parser import AnswerError, parse_plan

ACCEPTED = "accepted"
"""Beginning of the guard's verdict on a plan that it accepts."""


def checked_words(answer: str, request: ReasonerRequest) -> str:
    """Return the verdict on the plan in a query, or the error in it, which the model can correct.

    The whole plan is checked: its later steps where the steps before them end. What is missing has its amount.
    """
    assert request.check is not None
    try:
        plan = parse_plan(answer, request.scene)
    except AnswerError as error:
        return f"not a plan: {error}"
    verdict = request.check(plan)
    if request.assess is not None:
        whole = request.assess(plan)
        if not whole.accepted or verdict.startswith(ACCEPTED):
            verdict = assessment_text(whole)
    return with_sides_swapped(verdict) if request.scene.mirrored else verdict
