"""An entry of the memory: one solution that was tried in one intervention."""

from __future__ import annotations

from enum import Enum

from pydantic import Field

from stucksolver.scene import MAX_WORDS, Interpretation
from stucksolver.scene.base_model import FrozenModel
from stucksolver_passenger.memory.features import SceneFeatures
from stucksolver_passenger.memory.solution import Solution


class SolutionOutcome(str, Enum):
    """Outcome of a solution."""

    WORKED = "worked"
    """The plan was executed last, and the vehicle recovered."""
    FAILED = "failed"
    """The plan was aborted, or executed without progress of the vehicle."""
    REFUSED = "refused"
    """The guard rejected the plan, or a person declined its approval."""
    UNFINISHED = "unfinished"
    """The drive ended first, so the result is unknown."""


COUNTED = frozenset({SolutionOutcome.WORKED, SolutionOutcome.FAILED, SolutionOutcome.REFUSED})
"""Outcomes that count for or against a solution."""


class TriedSolution(FrozenModel):
    """One solution that was tried, and its outcome.

    Attributes:
        at_s: Time in seconds since 1970.
        vehicle: The vehicle's name in its stack.
        scene: Features of the scene.
        text: The passenger's utterance; empty if the solution followed no guidance.
        reading: Interpretation of the utterance; None without one.
        solution: None if nothing was tried in spite of guidance.
        proposer: Name of the reasoner.
        questions: Number of questions to people in the intervention before it ended.
    """

    at_s: float
    vehicle: str = Field(max_length=40)
    scene: SceneFeatures
    text: str = Field(default="", max_length=MAX_WORDS)
    reading: Interpretation | None = None
    solution: Solution | None = None
    behaviors: tuple[str, ...] = ()
    proposer: str = Field(default="", max_length=100)
    ending: SolutionOutcome
    how: str = Field(default="", max_length=300)
    questions: int = Field(default=0, ge=0)
    took_s: float | None = None
    """Time from the start of the plan to its end or the recovery (s, the vehicle's clock)."""

    @property
    def guided(self) -> bool:
        """True if it followed guidance of a passenger."""
        return self.reading is not None
