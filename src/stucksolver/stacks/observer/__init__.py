"""A car that somebody else drives, as StuckSolver meets it: looked at, never touched."""

from stucksolver.stacks.observer.observed import ObservedStack
from stucksolver.stacks.observer.watching import NoSuchCar, Watching, find_car

__all__ = ["NoSuchCar", "ObservedStack", "Watching", "find_car"]
