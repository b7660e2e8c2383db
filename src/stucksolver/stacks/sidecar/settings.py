"""What the stack may ask of the solver in its `hello`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from pydantic import Field

from stucksolver.detect import DetectorSettings
from stucksolver.ladder import find_ladder
from stucksolver.reason import Reasoner
from stucksolver.reason.make import make_reasoner
from stucksolver.record import Recorder
from stucksolver.scene.model import Model
from stucksolver.solver import Event, MakeScene, StuckSolver

NONE = "none"
"""The recovery of a driver that nobody helps."""


class Settings(Model):
    """As the arguments of `StuckSolver`, in words."""

    recovery: str = "rules"
    """The reasoner of the ladder's rung `rules`, by its words: `rules`, `openai:MODEL`, `recorded:FOLDER`."""
    reasoner: str | None = None
    """That of the rung `model`; None leaves the rung out."""
    ladder: str | None = None
    clock: str = "lockstep"
    detector: dict[str, float] = Field(default_factory=dict)
    record: Path | None = None
    """A folder for the record of each intervention."""
    perception: Literal["privileged", "sensors"] = "privileged"
    """Where the objects come from; results must say it."""
    rig: Path | None = None
    """The calibration of a vehicle that sees by its own sensors; None is the one that ships."""
    driver: Literal["behavior", "planner"] = "planner"
    """Who drives a vehicle that sees by its own sensors; all others have a driver of their own."""
    behavior: Literal["cautious", "normal", "aggressive"] = "normal"
    """Of that driver."""
    seed: int = 0
    """Of the noise of that vehicle's wheels."""

    @property
    def helps(self) -> bool:
        """Is there a reasoner at all? Without one the driver drives alone."""
        return self.recovery != NONE

    def recorder(self) -> Recorder | None:
        """Where a record is asked for; to be closed, or broken off, when the stack has gone."""
        return None if self.record is None else Recorder(self.record)

    def solver(self, scene: MakeScene, on_event: Callable[[Event], None], recorder: Recorder | None) -> StuckSolver:
        """Raises what `find_ladder` and `make_reasoner` raise."""
        models: dict[str, Reasoner] = {} if self.reasoner is None else {"model": make_reasoner(self.reasoner)}
        return StuckSolver(
            scene,
            ladder=find_ladder(self.ladder),
            reasoner=make_reasoner(self.recovery),
            models=models,
            detector=DetectorSettings(**self.detector),
            clock=self.clock,
            on_event=on_event,
            record=recorder,
        )
