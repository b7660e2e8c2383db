"""The menu of a query: what the search found, for a reasoner that chooses instead of inventing.

Every plan of it was assessed by the guard. The reasoner may choose one by its letter, or propose another plan; either
is judged again when the answer arrives.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.assessment import PlanAssessment, PlanAssessor
from stucksolver.plan.behaviors import Behavior
from stucksolver.plan.mirror import mirrored_plan
from stucksolver.plan.plan_text import assessment_text, plan_text
from stucksolver.reasoners.search.plan_search import Candidate, search_for
from stucksolver.reasoners.search.plan_value import shortfall_m
from stucksolver.reasoners.search.way_out import way_out
from stucksolver.scene import Scene
from stucksolver.scene.mirror import with_sides_swapped

LETTERS = "ABCDEF"
"""Letters of the plans. There are no more plans than letters: each costs some 30 tokens. Ours."""
NEARLY_M = 30.0
"""A plan that is further from being accepted is not listed (m, as `shortfall_m` weighs it). Ours: a meter of room, or
150 m of sight.
"""


@dataclass(frozen=True)
class MenuItem:
    """A plan to choose.

    Attributes:
        letter: Letter that an answer names.
        plan: The plan, in the solver's frame.
        assessment: The guard's assessment of all its steps at the time of the query.
    """

    letter: str
    plan: RecoveryPlan
    assessment: PlanAssessment

    @property
    def accepted(self) -> bool:
        """True if the guard accepts the whole plan now."""
        return self.assessment.accepted

    @property
    def text(self) -> str:
        """One line: letter, behaviors with their values, time (s), gap and margin (m), or what is missing."""
        return f"{self.letter} {plan_text(self.plan)}: {assessment_text(self.assessment)}"

    def mirrored(self) -> MenuItem:
        """Return the item with left and right swapped, for a reader that gets the scene as it is in the image."""
        lacking = tuple(
            item.model_copy(update={"detail": with_sides_swapped(item.detail)}) for item in self.assessment.shortfalls
        )
        assessment = self.assessment.model_copy(update={"shortfalls": lacking})
        return replace(self, plan=mirrored_plan(self.plan), assessment=assessment)


def plan_menu(scene: Scene, assess: PlanAssessor, most: int = len(LETTERS)) -> tuple[MenuItem, ...]:
    """Return up to six plans: those that the guard accepts now, then those that it nearly accepts. Deterministic.

    A plan is nearly accepted if traffic or a person's approval is all that is missing, or if the amount of everything
    else that is missing is known and small. Of plans that differ in numbers only, the best one is listed, and of
    refused plans with the same last behavior the one that lacks the least.

    Args:
        scene: The scene of the query.
        assess: The guard's assessment of a whole plan.
        most: Maximum number of plans.
    """
    found = [*_ways_out(scene, assess), *_searched(scene, assess)]
    found = [candidate for candidate in found if _is_near(candidate.assessment)]
    # The order of the search is kept among the accepted plans, and among the others.
    ordered = sorted(_different(found), key=lambda candidate: not candidate.assessment.accepted)
    pairs = zip(LETTERS[:most], ordered, strict=False)
    return tuple(MenuItem(letter, candidate.plan, candidate.assessment) for letter, candidate in pairs)


def _ways_out(scene: Scene, assess: PlanAssessor) -> list[Candidate]:
    """Return the shortest way out of a zone in which no vehicle should stop, if the ego is in one."""
    out = None if scene.guidance is not None else way_out(scene, assess)
    return [] if out is None else [Candidate(out, assess(out), 0.0)]


def _searched(scene: Scene, assess: PlanAssessor) -> tuple[Candidate, ...]:
    search = search_for(scene, assess)
    search.run()
    return search.ranked()


def _is_near(assessment: PlanAssessment) -> bool:
    """True if a plan is accepted, or if all that is missing passes, can be approved, or has a known small amount."""
    known = all(item.passing or item.approval or item.missing is not None for item in assessment.shortfalls)
    return known and shortfall_m(assessment) <= NEARLY_M


def _different(candidates: Iterable[Candidate]) -> list[Candidate]:
    """Return the first possible plan of each sequence of behaviors, and the first refused one of each last behavior.

    Behaviors differ if their sides or objects do, and not if only their numbers do. A refused plan is of no use beside
    a possible one that ends alike.
    """
    kept: dict[tuple[object, ...], Candidate] = {}
    ends: set[tuple[object, ...]] = set()
    for candidate in candidates:
        steps, end = _kinds(candidate.plan.behaviors), _kinds(candidate.plan.behaviors[-1:])
        if candidate.possible and steps not in kept:
            kept[steps] = candidate
            ends.add(end)
        elif not candidate.possible and end not in ends:
            kept[end] = candidate
            ends.add(end)
    return list(kept.values())


def _kinds(behaviors: Iterable[Behavior]) -> tuple[object, ...]:
    """Return the names, sides and objects of behaviors, without their numbers."""
    values = (value for behavior in behaviors for value in behavior.model_dump().values())
    return tuple(value for value in values if not isinstance(value, float))
