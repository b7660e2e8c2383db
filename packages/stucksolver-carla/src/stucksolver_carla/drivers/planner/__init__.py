"""A second base driver: it compares ways past what blocks its lane, each rolled out against predictions of
everybody.
"""

from stucksolver_carla.drivers.planner.planner_driver import PlannerDriver

__all__ = ["PlannerDriver"]
