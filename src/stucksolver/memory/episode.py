"""One thing that was tried in one intervention: what is remembered of it."""

from __future__ import annotations

from enum import Enum

from pydantic import Field

from stucksolver.memory.features import SceneFeatures
from stucksolver.memory.solution import Solution
from stucksolver.scene import MAX_WORDS, Reading
from stucksolver.scene.model import Model


class Ending(str, Enum):
    """How it ended."""

    WORKED = "worked"
    """It was carried out last, and the vehicle made its way."""
    FAILED = "failed"
    """It was given up, or carried out without the vehicle getting on."""
    REFUSED = "refused"
    """The guard, or a person whose yes it needed, did not allow it."""
    UNFINISHED = "unfinished"
    """The drive ended first: nothing is known of it."""


COUNTED = frozenset({Ending.WORKED, Ending.FAILED, Ending.REFUSED})
"""Endings that say something about a solution."""


class Episode(Model):
    """`at_s`: seconds since 1970. `vehicle`: whose it was, as its stack calls it.

    `text`, `reading`: what the passenger had said for it, and what that was understood as; empty and None for what the
    vehicle tried by itself. `solution`: None where nothing was tried in spite of the words. `proposer`: name of the
    reasoner. `questions`: so many were put to people in the intervention before it ended.
    """

    at_s: float
    vehicle: str = Field(max_length=40)
    scene: SceneFeatures
    text: str = Field(default="", max_length=MAX_WORDS)
    reading: Reading | None = None
    solution: Solution | None = None
    behaviors: tuple[str, ...] = ()
    proposer: str = Field(default="", max_length=100)
    ending: Ending
    how: str = Field(default="", max_length=300)
    questions: int = Field(default=0, ge=0)
    took_s: float | None = None
    """From the start of the plan to its end, or to the recovery (s, of the vehicle's clock)."""

    @property
    def guided(self) -> bool:
        """Did it follow a passenger's words?"""
        return self.reading is not None
