"""Gets an immobilized autonomous vehicle moving again, and proves each plan safe before and while it runs."""

from stucksolver.decision import CONTINUE, Continue, Directive, Execute, Replan, SafeStop
from stucksolver.guard import Guard, GuardPolicy
from stucksolver.ladder import Ladder
from stucksolver.scene import Scene, Status, Surroundings
from stucksolver.solver import StuckSolver

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
]
