"""When a passenger's own words are the yes to what follows from them."""

from __future__ import annotations

from stucksolver.decision import asks_for
from stucksolver.decision.behaviors import REGISTRY
from stucksolver.scene import Reading
from stucksolver.solver import Question, QuestionKind


def consents(reading: Reading | None, question: Question | None) -> bool:
    """Has the passenger asked for this very plan already?

    "Please go round it" need not be answered with "May I go round it?". That holds only where the yes releases nothing
    but the plan's behaviours: for a rule of the road, such as a solid line, the question is asked all the same.
    """
    if question is None or question.to != "passenger" or question.kind is not QuestionKind.APPROVAL:
        return False
    only_behaviors = all(name in REGISTRY for name in question.needs)
    return question.plan is not None and only_behaviors and asks_for(reading, question.plan)
