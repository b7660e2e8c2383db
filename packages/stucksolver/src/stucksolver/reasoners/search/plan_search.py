"""General search for a plan: behaviors on a grid, refined around what the guard nearly accepts.

No situation is named here. What a plan does follows from its behaviors, whether it is allowed follows from the guard.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from stucksolver.plan import GuidanceIntent, RecoveryPlan, plan_matches_intent
from stucksolver.plan.assessment import PlanAssessment, PlanAssessor
from stucksolver.plan.behaviors import Behavior, parse_behavior
from stucksolver.reasoners.duties.analysis import NEAR_M
from stucksolver.reasoners.search.behavior_grid import behaviors_on_grid, clipped
from stucksolver.reasoners.search.plan_value import (
    FAILED_COST_M,
    has_failed,
    is_hopeless,
    is_worth_driving,
    shortfall_m,
    value_m,
)
from stucksolver.reasoners.search.preparations import Steps, half_way, moves_for_shorter_gap, preparations
from stucksolver.scene import AttemptOutcome, RejectCode, Scene, SceneObject
from stucksolver.scene.own_path import IN_LANE_M, nearest_ahead

MOST_CHECKS = 240
"""Number of plans that one search assesses. A plan takes one or a few milliseconds. Ours."""
NEARLY = 6
"""Number of refused plans around which the search is refined. Ours."""
GOOD_ENOUGH_M = 6.0
"""A refinement must promise this much more than what is accepted already (m), or the search ends. Ours."""
FAILED_S = 30.0
"""Time for which a failed plan is put off (s)."""
FACTORS = (0.5, 0.75, 1.25, 1.5)
"""Factors on a parameter of a plan that is nearly accepted. Ours: a pass at 30 km/h needs less sight than at 20."""
MOST_HALVES = 3
"""Number of aborted plans with preparations, after which the same behavior is not prepared again. Ours."""
STREAM = frozenset({RejectCode.LANE_ENTRY, RejectCode.ONCOMING_GAP, RejectCode.COLLISION, RejectCode.GAP})
"""Codes of plans to which traffic left no gap."""
STREAM_TRIES, STREAM_S = 2, 60.0
"""Traffic is a stream once it has left a plan no gap this often within this time (s). Only then is a move made that
needs a shorter gap, because a gap may come. Ours.
"""
OVERTAKEN_M = 45.0
"""A passenger may ask to overtake a vehicle up to this distance ahead (m). Ours."""
LAST_RANK = 100
"""Rank of behaviors that solve nothing by themselves."""
LONGEST = 6
"""Most behaviors in a plan."""


@dataclass(frozen=True)
class Candidate:
    """A plan with the guard's assessment and its value (m)."""

    plan: RecoveryPlan
    assessment: PlanAssessment
    value: float

    @property
    def possible(self) -> bool:
        """True if the guard accepts it now, after the traffic, or with a person's approval."""
        lacking = self.assessment.shortfalls
        return all(item.passing or item.approval for item in lacking)


@dataclass
class SearchResult:
    """Outcome of a search.

    Attributes:
        best: Best plan that is possible; None if there is none.
        nearly: The refused plan that is nearest to being accepted; None if nothing was refused.
    """

    best: Candidate | None
    nearly: Candidate | None


@dataclass
class PlanSearch:
    """One search in one scene.

    Args:
        scene: The scene.
        assess: The guard's assessment of a whole plan.
        fits: Returns True for plans that may be proposed at all, such as those that a passenger asks for.
        passes: Id of an object that the plan must pass, if a passenger asks for that.
        most_checks: Number of plans to assess.
    """

    scene: Scene
    assess: PlanAssessor
    fits: Callable[[RecoveryPlan], bool]
    passes: str | None = None
    most_checks: int = MOST_CHECKS
    _known: dict[Steps, Candidate] = field(default_factory=dict)

    def run(self) -> SearchResult:
        """Return the best plan, and the plan that is nearest to being accepted."""
        singles = self._tried((behavior,) for behavior in behaviors_on_grid(self.scene))
        self._tried(self._returns(singles))
        if not self._settled():
            self._tried(self._refined())
        if not self._settled():
            self._tried(self._prepared())
        return self._result()

    def ranked(self) -> tuple[Candidate, ...]:
        """Return the plans of `run`, best first: what is possible by its value, then what is nearest to accepted."""
        possible = sorted(self._worthwhile(), key=lambda c: -c.value)
        refused = [c for c in self._known.values() if not c.possible and self._could_help(c)]
        return (*possible, *sorted(refused, key=lambda c: shortfall_m(c.assessment)))

    def _tried(self, plans: Iterable[Steps]) -> list[Candidate]:
        """Assess plans until the budget is used up."""
        found = []
        for steps in plans:
            if len(self._known) >= self.most_checks:
                break
            if steps in self._known or len(steps) > LONGEST:
                continue
            plan = RecoveryPlan(behaviors=steps)
            if not self.fits(plan):
                continue
            assessment = self.assess(plan)
            value = value_m(plan, assessment) - FAILED_COST_M * has_failed(self.scene, plan, FAILED_S)
            candidate = self._known[steps] = Candidate(plan, assessment, value)
            found.append(candidate)
        return found

    def _returns(self, candidates: list[Candidate]) -> Iterator[Steps]:
        """Yield plans that end beside the route's lane, each followed by a behavior that leads back."""
        away = [c for c in candidates if c.possible and abs(c.assessment.offset_m) > IN_LANE_M]
        finals = [c.plan.behaviors for c in candidates]
        for candidate in sorted(away, key=lambda c: -c.value)[: 2 * NEARLY]:
            yield from ((*candidate.plan.behaviors, *back) for back in finals if _leads_back(candidate, back[0]))

    def _refined(self) -> Iterator[Steps]:
        """Yield variants of the plans that are nearly accepted, one number changed at a time."""
        for candidate in self._nearly():
            for k, behavior in enumerate(candidate.plan.behaviors):
                for other in _variants(behavior):
                    steps = candidate.plan.behaviors
                    yield (*steps[:k], other, *steps[k + 1 :])

    def _prepared(self) -> Iterator[Steps]:
        """Yield the plans that are nearly accepted, each after moves that may give room or sight."""
        queues = [iter([(*moves, *c.plan.behaviors) for moves in self._preparations(c)]) for c in self._nearly()]
        # In turns, so that the budget is not used up on one of them.
        while queues:
            for queue in list(queues):
                steps = next(queue, None)
                if steps is None:
                    queues.remove(queue)
                else:
                    yield steps

    def _preparations(self, candidate: Candidate) -> Iterator[Steps]:
        if self._waits_in_vain(candidate):
            return moves_for_shorter_gap(self.scene)
        return preparations(self.scene, candidate.assessment)

    def _nearly(self) -> list[Candidate]:
        """Return the refused plans that are nearest to being accepted, of every sequence of behaviors the best two."""
        lacking = [c for c in self._known.values() if not c.possible or self._waits_in_vain(c)]
        refused = [c for c in lacking if self._could_help(c)]
        kept: dict[tuple[str, ...], list[Candidate]] = {}
        for candidate in sorted(refused, key=lambda c: shortfall_m(c.assessment)):
            group = kept.setdefault(tuple(b.name for b in candidate.plan.behaviors), [])
            if len(group) < 2:
                group.append(candidate)
        return sorted((c for group in kept.values() for c in group), key=lambda c: shortfall_m(c.assessment))[:NEARLY]

    def _could_help(self, candidate: Candidate) -> bool:
        """True if a refused plan would lead past what is in the path ahead, and something can make it acceptable.

        A plan of which a preparation is refused says nothing about what follows it.
        """
        steps = candidate.plan.behaviors
        if candidate.assessment.step is not None and len(steps) > 1 + candidate.assessment.step:
            return False
        stays_behind = all(b.stays_behind_blocker or _only_prepares(b) for b in steps)
        behind = stays_behind and nearest_ahead(self.scene, NEAR_M) is not None
        return not behind and not is_hopeless(candidate.assessment)

    def _waits_in_vain(self, candidate: Candidate) -> bool:
        """True if a plan waits for traffic that has left no gap to such plans."""
        last = candidate.plan.behaviors[-1].name
        tries = [a for a in self.scene.attempts if a.behaviors[-1:] == (last,) and not STREAM.isdisjoint(a.codes)]
        recent = [a for a in tries if self.scene.time_s - a.time_s < STREAM_S]
        return candidate.assessment.waits_for_traffic and len(recent) >= STREAM_TRIES

    def _worthwhile(self) -> list[Candidate]:
        lead = nearest_ahead(self.scene, math.inf)
        free_now_m = math.inf if lead is None else max(lead.gap_m or 0.0, 0.0)
        return [c for c in self._known.values() if self._is_possible(c) and is_worth_driving(c.assessment, free_now_m)]

    def _is_possible(self, candidate: Candidate) -> bool:
        """True if a plan is possible, passes what it must pass, and needs no approval after a person has said no."""
        declined = any(attempt.ended is AttemptOutcome.DECLINED for attempt in self.scene.attempts)
        asks = any(item.approval for item in candidate.assessment.shortfalls)
        passes = self.passes is None or self.passes in candidate.assessment.passed
        return candidate.possible and passes and not (declined and asks) and not self._ends_half_way(candidate.plan)

    def _ends_half_way(self, plan: RecoveryPlan) -> bool:
        """True if plans with preparations for the same behavior were aborted often enough."""
        last = plan.behaviors[-1].name
        return len(plan.behaviors) > 1 and sum(names[-1] == last for names in half_way(self.scene)) >= MOST_HALVES

    def _settled(self) -> bool:
        """True if a plan that needs nothing else is accepted, so that a refinement can hardly be better."""
        return any(c.assessment.accepted and c.value > GOOD_ENOUGH_M for c in self._worthwhile())

    def _result(self) -> SearchResult:
        possible = self._worthwhile()
        refused = [c for c in self._known.values() if not c.assessment.accepted and self._could_help(c)]
        nearly = min(refused, key=_explains, default=None)
        return SearchResult(max(possible, key=lambda c: c.value, default=None), nearly)


def search_for(scene: Scene, assess: PlanAssessor) -> PlanSearch:
    """Return the search for a scene: for every plan, or for those that the passenger asks for.

    Who asks to overtake wants to pass what is ahead: see `overtaken_by_request`.
    """
    reading = None if scene.guidance is None else scene.guidance.reading
    overtaken = overtaken_by_request(scene)

    def fits(plan: RecoveryPlan) -> bool:
        return reading is None or plan_matches_intent(reading, plan)

    return PlanSearch(scene, assess, fits, None if overtaken is None else overtaken.id)


def overtaken_by_request(scene: Scene) -> SceneObject | None:
    """Return the object that a passenger asks to overtake; None without such a request, or with nothing ahead."""
    reading = None if scene.guidance is None else scene.guidance.reading
    if reading is None or reading.intent is not GuidanceIntent.OVERTAKE:
        return None
    return nearest_ahead(scene, OVERTAKEN_M)


def _explains(candidate: Candidate) -> tuple[bool, int, int, float]:
    """Return the rank of a refused plan as an explanation: a plan that leads into an object, or is too fast, explains
    the least.
    """
    lacking = candidate.assessment.shortfalls
    hits = any(item.code in (RejectCode.COLLISION, RejectCode.OVERSPEED) and not item.passing for item in lacking)
    rank = min(b.solution_rank or LAST_RANK for b in candidate.plan.behaviors)
    return hits, len(candidate.plan.behaviors), rank, shortfall_m(candidate.assessment)


def _only_prepares(behavior: Behavior) -> bool:
    return behavior.prepares and not behavior.intents


def _leads_back(candidate: Candidate, back: Behavior) -> bool:
    """True if a behavior may lead back into the route's lane after a plan that ends beside it."""
    side = back.passing_side
    if side is not None:
        return back.shifts_laterally and (side.value == "right") == (candidate.assessment.offset_m > 0.0)
    return back.starts_at_roadside


def _variants(behavior: Behavior) -> Iterator[Behavior]:
    """Yield a behavior with one of its numbers changed, within the bounds of its schema."""
    schema = type(behavior).model_json_schema()["properties"]
    data = behavior.model_dump()
    for name, item in schema.items():
        if item.get("type") != "number":
            continue
        for factor in FACTORS:
            changed = clipped(data[name] * factor, item)
            if changed != data[name]:
                yield parse_behavior({**data, name: changed})
