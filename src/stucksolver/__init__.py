"""Gets an immobilized autonomous vehicle moving again, and proves each plan safe before and while it runs."""

from stucksolver.decision import CONTINUE, Continue, Directive, Execute, Replan, SafeStop
from stucksolver.guard import Guard, GuardPolicy
from stucksolver.scene import Scene, Status, Surroundings
from stucksolver.solver import SolverSettings, StuckSolver

__all__ = [
    "CONTINUE",
    "Continue",
    "Directive",
    "Execute",
    "Guard",
    "GuardPolicy",
    "Replan",
    "SafeStop",
    "Scene",
    "SolverSettings",
    "Status",
    "StuckSolver",
    "Surroundings",
]
