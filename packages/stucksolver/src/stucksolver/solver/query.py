"""Query to a reasoner."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan import WaitReason
from stucksolver.query_budget import QueryBudget
from stucksolver.scene import Interpretation, Scene, Surroundings


@dataclass(frozen=True)
class Query:
    """Query to a reasoner. Its number is unique in a solver.

    Attributes:
        number: Number of the query.
        reasoner: Name of the reasoner in the ladder.
        scene: Scene as sent to the reasoner.
        asked_s: Time of the query (s, the solver's own time).
        deadline_s: Time for the answer (s).
        screen: True if the rules answer instead when the vehicle has a legitimate wait.
        outlived: Reasons to wait that have exceeded their limit.
        seen: Surroundings with which the guard checks plans that the reasoner considers.
        reading: Interpretation of the passenger's guidance, for the same check.
        budget: Bounds of the rung on the use of the reasoner.
    """

    number: int
    reasoner: str
    scene: Scene
    asked_s: float
    deadline_s: float
    screen: bool
    outlived: frozenset[WaitReason]
    seen: Surroundings | None
    reading: Interpretation | None
    budget: QueryBudget | None = None


@dataclass(frozen=True)
class NoAnswer:
    """Reason for a missing answer. `malformed`: there was an answer, but it was unusable."""

    why: str
    malformed: bool = False
