"""StuckSolver on CARLA's own BehaviorAgent, in the process that drives it."""

from stucksolver.stacks.behavior_agent.attach import AttachedAgent, attach

__all__ = ["AttachedAgent", "attach"]
