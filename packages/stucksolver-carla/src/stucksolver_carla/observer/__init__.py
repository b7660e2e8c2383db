"""A car that someone else drives: observed, never touched."""

from stucksolver_carla.observer.observed_stack import ObservedStack
from stucksolver_carla.observer.vehicle_observer import VehicleNotFoundError, VehicleObserver, find_car

__all__ = ["ObservedStack", "VehicleNotFoundError", "VehicleObserver", "find_car"]
