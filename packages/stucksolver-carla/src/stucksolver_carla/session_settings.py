"""The settings that a stack may send in its `hello`."""

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
"""The name of the recovery that does nothing."""


class SessionSettings(FrozenModel):
    """The arguments of `StuckSolver`, by name."""

    recovery: str = "rules"
    """The reasoner of the ladder's rung `rules`, by name: `rules`, `openai:MODEL`, `recorded:FOLDER`."""
    reasoner: str | None = None
    """The reasoner of the rung `model`; None leaves the rung out."""
    ladder: str | None = None
    clock: str = "lockstep"
    detector: dict[str, float] = Field(default_factory=dict)
    record: Path | None = None
    """Folder for the record of each intervention; None for no records."""
    perception: Literal["privileged", "sensors"] = "privileged"
    """Where the objects come from; results must state it."""
    rig: Path | None = None
    """The rig file of a vehicle with its own perception; None for the one that ships with the package."""
    driver: Literal["behavior", "planner"] = "planner"
    """The driver of a vehicle with its own perception; all others have their own driver."""
    behavior: Literal["cautious", "normal", "aggressive"] = "normal"
    """The behavior of that driver."""
    seed: int = 0
    """Seed of the noise of that vehicle's wheels."""

    @property
    def helps(self) -> bool:
        """True if there is a reasoner; without one the driver drives alone."""
        return self.recovery != NONE

    def recorder(self) -> Recorder | None:
        """Return the recorder if records are requested; it must be closed, or broken off, when the stack is gone."""
        return None if self.record is None else Recorder(self.record)

    def solver(self, scene: MakeScene, on_event: Callable[[Event], None], recorder: Recorder | None) -> StuckSolver:
        """Return the solver. Raises what `find_ladder` and `make_reasoner` raise."""
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
