"""Interface that receives everything needed to derive each step again. The record implements it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from stucksolver.guard import GuardPolicy
from stucksolver.immobilization import DetectorSettings
from stucksolver.ladder import Ladder
from stucksolver.plan import Directive
from stucksolver.solver.events import Event, StepOutput
from stucksolver.solver.state_machine.inputs import Inputs, SceneInput, SurroundingsInput
from stucksolver.solver.state_machine.state import State


@dataclass(frozen=True)
class SolverInfo:
    """Setup of a solver. `reasoners` maps the rungs' names to the reasoners' own names."""

    ladder: Ladder
    policy: GuardPolicy
    clock: str
    detector: DetectorSettings
    reasoners: Mapping[str, str]
    ask_back: str
    observe_only: bool
    vehicle_id: str = ""


@dataclass(frozen=True)
class TransitionStep:
    """One call of `transition`. Everything else can be recomputed from `before` and the inputs.

    `sight` and `snapshot` are the results of the inputs' `look` and `scene`, None if these were not called.
    """

    before: State
    inputs: Inputs
    sight: SurroundingsInput | None
    snapshot: SceneInput | None
    after: State
    directive: Directive
    outputs: tuple[StepOutput, ...]


class StepListener(Protocol):
    """Receiver of every step. If it raises, the solver reports it once, stops calling it, and drives on."""

    def begin(self, facts: SolverInfo) -> None:
        """Receive the setup, once, when the solver is created."""

    def step(self, step: TransitionStep) -> None:
        """Receive a tick on which the solver was engaged or might have been."""

    def fault(self, event: Event) -> None:
        """Receive a fault outside a step, for example an invalid status or a listener that failed."""
