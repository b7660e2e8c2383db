"""Contains the second built-in driver, which compares paths past a blocker in rollouts against predicted traffic."""

from stucksolver_carla.drivers.planner.planner_driver import PlannerDriver

__all__ = ["PlannerDriver"]
