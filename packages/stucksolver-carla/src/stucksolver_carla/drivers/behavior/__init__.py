"""Contains the BehaviorAgent-like driver, its interface, and the types of its routes and paths."""

from stucksolver_carla.drivers.behavior.behavior_driver import BehaviorDriver
from stucksolver_carla.drivers.behavior.options import DriverOptions
from stucksolver_carla.drivers.behavior.routing import RouteError, trace_route
from stucksolver_carla.drivers.behavior.swept_path import Hazard
from stucksolver_carla.drivers.driver_interface import DrivePoint, Driver, PathFollower, RouteHolder, RoutePoint

__all__ = [
    "BehaviorDriver",
    "DrivePoint",
    "Driver",
    "DriverOptions",
    "Hazard",
    "PathFollower",
    "RouteError",
    "RouteHolder",
    "RoutePoint",
    "trace_route",
]
