"""Finds solutions of similar scenes with their success rates, the most certain first."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from stucksolver.scene import REQUESTS, GuidanceIntent, Interpretation
from stucksolver_passenger.memory.features import SceneFeatures, alike
from stucksolver_passenger.memory.solution import Solution
from stucksolver_passenger.memory.success_rate import PROPOSED_FROM, SuccessRate
from stucksolver_passenger.memory.tried_solution import COUNTED, SolutionOutcome, TriedSolution

UNNAMED_WISHES = frozenset({GuidanceIntent.GO})
"""Intents to move on without a specific solution. Any solution that worked in a similar scene matches them."""


@dataclass(frozen=True)
class RecalledSolution:
    """A solution and its success rate in similar scenes."""

    solution: Solution
    rate: SuccessRate

    @property
    def trusted(self) -> bool:
        """True if it has worked often enough to be proposed."""
        return self.rate.lower >= PROPOSED_FROM


def recall(
    episodes: Iterable[TriedSolution], scene: SceneFeatures, reading: Interpretation | None = None
) -> tuple[RecalledSolution, ...]:
    """Return solutions of scenes similar to `scene`, the most certain first.

    With a passenger's `reading`, only matching solutions are returned: the same request, and the same side if the
    passenger named one. A request only to move on matches all of them.
    """
    rates: dict[Solution, SuccessRate] = {}
    for episode in episodes:
        solution = episode.solution
        if solution is None or episode.ending not in COUNTED or not alike(episode.scene, scene):
            continue
        if reading is not None and not means(reading, solution):
            continue
        rates[solution] = rates.get(solution, SuccessRate()).with_one(episode.ending is SolutionOutcome.WORKED)
    found = [RecalledSolution(solution, rate) for solution, rate in rates.items()]
    return tuple(sorted(found, key=lambda item: (-item.rate.lower, -item.rate.mean, item.solution.name)))


def means(reading: Interpretation, solution: Solution) -> bool:
    """True if the solution is what the passenger requests."""
    if reading.intent not in REQUESTS or reading.negated:
        return False
    if reading.intent in UNNAMED_WISHES:
        return True
    turns = reading.intent is GuidanceIntent.TURN_AROUND and solution.intent is GuidanceIntent.REROUTE
    sides = reading.side is None or solution.side is None or reading.side is solution.side
    return (reading.intent is solution.intent or turns) and sides
