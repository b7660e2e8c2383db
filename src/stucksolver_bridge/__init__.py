"""StuckSolver in other people's processes: Python 3.7 and later, standard library only, `carla` handed over."""

from stucksolver_bridge.agent_driver import AgentDriver

__all__ = ["AgentDriver"]
