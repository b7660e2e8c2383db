"""Connects StuckSolver with CARLA: the stack of a vehicle, two built-in drivers, and `attach` for CARLA's agents."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stucksolver_carla.attached_agent import AttachedAgent, attach

__all__ = ["AttachedAgent", "attach"]


def __getattr__(name: str) -> Any:
    # A late import: `attach` requires the carla package; other parts, such as the sidecar of a stack without CARLA, do
    # not.
    if name in __all__:
        from stucksolver_carla import attached_agent

        return getattr(attached_agent, name)
    raise AttributeError(f"module 'stucksolver_carla' has no attribute {name!r}")
