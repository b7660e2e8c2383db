"""StuckSolver on a vehicle in CARLA (or carlette), through the `carla` client alone."""

from stucksolver.stacks.carla_stack.senses import CarlaSenses
from stucksolver.stacks.carla_stack.stack import CarlaStack

__all__ = ["CarlaSenses", "CarlaStack"]
