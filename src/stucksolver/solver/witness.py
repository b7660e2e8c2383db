"""Who is told everything that is needed to derive every step again: the record is one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from stucksolver.decision import Directive
from stucksolver.detect import DetectorSettings
from stucksolver.guard import GuardPolicy
from stucksolver.ladder import Ladder
from stucksolver.solver.events import Event, Told
from stucksolver.solver.machine.inputs import Inputs, Sight, Snapshot
from stucksolver.solver.machine.state import State


@dataclass(frozen=True)
class Facts:
    """What a solver is made of. `reasoners`: the rungs' names for them, and their own."""

    ladder: Ladder
    policy: GuardPolicy
    clock: str
    detector: DetectorSettings
    reasoners: Mapping[str, str]
    ask_back: str
    observe_only: bool


@dataclass(frozen=True)
class StepTaken:
    """One call of `transition`: with `before` and the inputs, the rest can be derived again.

    `sight`, `snapshot`: what the inputs' `look` and `scene` gave, None where they were not called.
    """

    before: State
    inputs: Inputs
    sight: Sight | None
    snapshot: Snapshot | None
    after: State
    directive: Directive
    told: tuple[Told, ...]


class Witness(Protocol):
    """Is told of every step. What it raises ends it: the solver tells of it once, and drives on."""

    def begin(self, facts: Facts) -> None:
        """Called once, when the solver is made."""

    def step(self, step: StepTaken) -> None:
        """A tick on which something was, or might have been, the matter."""

    def fault(self, event: Event) -> None:
        """Something went wrong outside of a step: a status that is none, a listener that failed."""
