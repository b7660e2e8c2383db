"""Our base driver: its interface, and the types in which it gets its orders."""

from stucksolver.stacks.driver.driver import BehaviorDriver
from stucksolver.stacks.driver.hazards import Hazard
from stucksolver.stacks.driver.interface import DrivePoint, Driver, DrivesPath, HasRoute, RoutePoint
from stucksolver.stacks.driver.options import DriverOptions
from stucksolver.stacks.driver.routing import RouteError, trace_route

__all__ = [
    "BehaviorDriver",
    "DrivePoint",
    "Driver",
    "DriverOptions",
    "DrivesPath",
    "HasRoute",
    "Hazard",
    "RouteError",
    "RoutePoint",
    "trace_route",
]
