"""When a passenger's own words already approve the plan that follows from them."""

from __future__ import annotations

from stucksolver.plan import plan_matches_intent
from stucksolver.plan.behaviors import REGISTRY
from stucksolver.scene import Interpretation
from stucksolver.solver import Question, QuestionKind


def implies_approval(reading: Interpretation | None, question: Question | None) -> bool:
    """True if the passenger has already asked for this very plan.

    "Please go round it" need not be answered with "May I go round it?". That holds only if the yes releases nothing but
    the plan's behaviours. For a rule of the road, such as a solid line, the question is still asked.
    """
    if question is None or question.to != "passenger" or question.kind is not QuestionKind.APPROVAL:
        return False
    only_behaviors = all(name in REGISTRY for name in question.needs)
    return question.plan is not None and only_behaviors and plan_matches_intent(reading, question.plan)
