"""Observes a vehicle that another program drives, without acting on it."""

from stucksolver_carla.observer.observed_stack import ObservedStack
from stucksolver_carla.observer.vehicle_observer import VehicleNotFoundError, VehicleObserver, find_vehicle

__all__ = ["ObservedStack", "VehicleNotFoundError", "VehicleObserver", "find_vehicle"]
