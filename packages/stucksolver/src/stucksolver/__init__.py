"""Gets an immobilized autonomous vehicle moving again, and examines each plan before and while it runs."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stucksolver.guard import Guard, GuardPolicy
    from stucksolver.ladder import Ladder
    from stucksolver.plan import CONTINUE, Continue, Directive, Execute, Replan, SafeStop
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

_HOMES = {
    "stucksolver.plan": ("CONTINUE", "Continue", "Directive", "Execute", "Replan", "SafeStop"),
    "stucksolver.guard": ("Guard", "GuardPolicy"),
    "stucksolver.ladder": ("Ladder",),
    "stucksolver.scene": ("Scene", "Status", "Surroundings"),
    "stucksolver.solver": ("StuckSolver",),
}


def __getattr__(name: str) -> Any:
    # Imported on first use, because a command's help needs none of it.
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(home), name)
    raise AttributeError(f"module 'stucksolver' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
