"""A question to a reasoner."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan import WaitReason
from stucksolver.scene import Interpretation, Scene, Surroundings


@dataclass(frozen=True)
class Query:
    """A question to a reasoner. Its number is unique in a solver.

    Attributes:
        number: Number of the question.
        reasoner: The ladder's name for the reasoner.
        scene: What the reasoner is told.
        asked_s: When it was asked (s, the solver's own time).
        deadline_s: Time for the answer (s).
        screen: The rules answer instead if the vehicle is only held up.
        outlived: Reasons to wait that have lasted too long.
        seen: The surroundings with which the guard checks plans that the reasoner considers.
        reading: The reading of the passenger's words, for the same check.
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


@dataclass(frozen=True)
class NoAnswer:
    """The reason why there is no answer. `malformed`: there was one, and it could not be used."""

    why: str
    malformed: bool = False
