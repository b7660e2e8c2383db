"""A question of the solver to a reasoner."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.decision import WaitReason
from stucksolver.scene import Reading, Scene, Surroundings


@dataclass(frozen=True)
class Query:
    """A question to a reasoner. Its number tells it from all others of a solver.

    `reasoner`: the ladder's name for it. `asked_s`: when it was asked, in the solver's own time. `deadline_s`: seconds
    for the answer. `screen`: rules answer in its place where the vehicle is only held up. `outlived`: reasons to wait
    that have lasted too long. `seen`, `reading`: with these the guard is asked about plans that the reasoner thinks of.
    """

    number: int
    reasoner: str
    scene: Scene
    asked_s: float
    deadline_s: float
    screen: bool
    outlived: frozenset[WaitReason]
    seen: Surroundings | None
    reading: Reading | None


@dataclass(frozen=True)
class NoAnswer:
    """Why there is none."""

    why: str
