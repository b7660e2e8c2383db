"""Connects StuckSolver with a vehicle in CARLA (or carlette), through the `carla` client alone."""

from stucksolver_carla.stack.carla_stack import CarlaStack
from stucksolver_carla.stack.scene_source import CarlaSceneSource

__all__ = ["CarlaSceneSource", "CarlaStack"]
