"""StuckSolver in CARLA: the vehicle, two base drivers, `attach` for CARLA's own agents, and Bench2Drive's entry."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stucksolver_carla.attached_agent import AttachedAgent, attach

__all__ = ["AttachedAgent", "attach"]


def __getattr__(name: str) -> Any:
    # `attach` needs the carla package; other parts, such as the sidecar of a stack without CARLA, do not.
    if name in __all__:
        from stucksolver_carla import attached_agent

        return getattr(attached_agent, name)
    raise AttributeError(f"module 'stucksolver_carla' has no attribute {name!r}")
