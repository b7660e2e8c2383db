"""Gets an immobilized autonomous vehicle moving again, and proves each plan safe before and while it runs."""

from typing import TYPE_CHECKING, Any

from stucksolver.decision import CONTINUE, Continue, Directive, Execute, Replan, SafeStop
from stucksolver.guard import Guard, GuardPolicy
from stucksolver.ladder import Ladder
from stucksolver.scene import Scene, Status, Surroundings
from stucksolver.solver import StuckSolver

if TYPE_CHECKING:
    from stucksolver.stacks.behavior_agent import attach

__all__ = [
    "CONTINUE",
    "Continue",
    "Directive",
    "Execute",
    "Guard",
    "GuardPolicy",
    "Ladder",
    "Replan",
    "SafeStop",
    "Scene",
    "Status",
    "StuckSolver",
    "Surroundings",
    "attach",
]


def __getattr__(name: str) -> Any:
    # Importing stucksolver must not import carla.
    if name == "attach":
        from stucksolver.stacks.behavior_agent import attach

        return attach
    raise AttributeError(f"module 'stucksolver' has no attribute {name!r}")
