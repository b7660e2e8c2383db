"""A car that someone else drives: observed, never touched."""

from stucksolver_carla.observer.observed_stack import ObservedStack
from stucksolver_carla.observer.vehicle_observer import NoSuchCar, Watching, find_car

__all__ = ["NoSuchCar", "ObservedStack", "Watching", "find_car"]
