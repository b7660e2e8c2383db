"""Defines the settings that a stack may send in its `hello`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from pydantic import Field

from stucksolver.immobilization import DetectorSettings
from stucksolver.ladder import find_ladder
from stucksolver.reasoners import Reasoner
from stucksolver.reasoners.factory import make_reasoner
from stucksolver.record import Recorder
from stucksolver.scene.base_model import FrozenModel
from stucksolver.solver import Event, MakeScene, StuckSolver

NONE = "none"
"""The recovery without a reasoner."""


class SessionSettings(FrozenModel):
    """The arguments of `StuckSolver`, by name."""

    recovery: str = "search"
    """The reasoner of the ladder's rung `reasoner`, by name: `search`, `openai:MODEL`, `recorded:FOLDER`."""
    reasoner: str | None = None
    """The reasoner of the rung `model`; None leaves the rung out."""
    ladder: str | None = None
    """Name or file of the ladder; None for the default one."""
    clock: str = "lockstep"
    """The clock of the solver."""
    detector: dict[str, float] = Field(default_factory=dict)
    """Changed fields of `DetectorSettings`."""
    record: Path | None = None
    """Folder for the record of each intervention; None for no records."""
    perception: Literal["privileged", "sensors"] = "privileged"
    """Source of the objects; results must state it."""
    rig: Path | None = None
    """The rig file with sensor-based perception; None for the file that ships with the package."""
    driver: Literal["behavior", "planner"] = "planner"
    """The driver with sensor-based perception. Otherwise the driver runs in the stack's process."""
    behavior: Literal["cautious", "normal", "aggressive"] = "normal"
    """The behavior of that driver."""
    seed: int = 0
    """Seed of the wheel noise with sensor-based perception."""

    @property
    def helps(self) -> bool:
        """True if there is a reasoner. Without one the driver drives alone."""
        return self.recovery != NONE

    def recorder(self) -> Recorder | None:
        """Return a recorder, or None without a folder. The caller must close it, or break it off if the stack fails."""
        return None if self.record is None else Recorder(self.record)

    def solver(self, scene: MakeScene, on_event: Callable[[Event], None], recorder: Recorder | None) -> StuckSolver:
        """Return the solver. Raises the errors of `find_ladder` and `make_reasoner`."""
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
