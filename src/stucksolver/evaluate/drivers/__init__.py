"""Who drives: our own driver, or an agent of the user's, by name."""

from stucksolver.evaluate.drivers.agent import Agent, AgentError, RouteDriver
from stucksolver.evaluate.drivers.make import DriverNameError, check_driver, make_driver

__all__ = ["Agent", "AgentError", "DriverNameError", "RouteDriver", "check_driver", "make_driver"]
