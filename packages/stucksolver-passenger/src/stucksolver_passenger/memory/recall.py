"""Finds solutions of similar scenes with their success rates, the surest first."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from stucksolver.scene import REQUESTS, GuidanceIntent, Reading
from stucksolver_passenger.memory.features import SceneFeatures, alike
from stucksolver_passenger.memory.solution import Solution
from stucksolver_passenger.memory.success_rate import PROPOSED_FROM, Rate
from stucksolver_passenger.memory.tried_solution import COUNTED, Ending, Episode

UNNAMED_WISHES = frozenset({GuidanceIntent.GO})
"""Words that ask to move on without saying how: anything that worked in a similar scene answers them."""


@dataclass(frozen=True)
class Remembered:
    """A solution and its success rate in similar scenes."""

    solution: Solution
    rate: Rate

    @property
    def trusted(self) -> bool:
        """True if it has worked often enough to be proposed."""
        return self.rate.lower >= PROPOSED_FROM


def recall(episodes: Iterable[Episode], scene: SceneFeatures, reading: Reading | None = None) -> tuple[Remembered, ...]:
    """Return solutions of scenes like `scene`, the surest first.

    With a passenger's `reading`, only solutions that match it are returned: the same request, on the same side if one
    was named. Words that only ask to move on match all of them.
    """
    rates: dict[Solution, Rate] = {}
    for episode in episodes:
        solution = episode.solution
        if solution is None or episode.ending not in COUNTED or not alike(episode.scene, scene):
            continue
        if reading is not None and not means(reading, solution):
            continue
        rates[solution] = rates.get(solution, Rate()).with_one(episode.ending is Ending.WORKED)
    found = [Remembered(solution, rate) for solution, rate in rates.items()]
    return tuple(sorted(found, key=lambda one: (-one.rate.lower, -one.rate.mean, one.solution.name)))


def means(reading: Reading, solution: Solution) -> bool:
    """True if the solution is what the words ask for."""
    if reading.intent not in REQUESTS or reading.negated:
        return False
    if reading.intent in UNNAMED_WISHES:
        return True
    turns = reading.intent is GuidanceIntent.TURN_ROUND and solution.intent is GuidanceIntent.REROUTE
    sides = reading.side is None or solution.side is None or reading.side is solution.side
    return (reading.intent is solution.intent or turns) and sides
