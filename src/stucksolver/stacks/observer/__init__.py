"""A car that someone else drives: observed, never touched."""

from stucksolver.stacks.observer.observed import ObservedStack
from stucksolver.stacks.observer.watching import NoSuchCar, Watching, find_car

__all__ = ["NoSuchCar", "ObservedStack", "Watching", "find_car"]
