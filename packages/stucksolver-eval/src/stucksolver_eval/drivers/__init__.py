"""The drivers by name: those of StuckSolver, or an agent of the user."""

from stucksolver_eval.drivers.agent import Agent, AgentError, RouteDriver
from stucksolver_eval.drivers.factory import DriverNameError, carries_sensors, check_driver, make_driver

__all__ = ["Agent", "AgentError", "DriverNameError", "RouteDriver", "carries_sensors", "check_driver", "make_driver"]
