"""A second base driver: it weighs ways past what blocks its lane, each rolled out against forecasts of everybody."""

from stucksolver.stacks.planner.driver import PlannerDriver

__all__ = ["PlannerDriver"]
