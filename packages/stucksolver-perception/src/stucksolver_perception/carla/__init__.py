"""A vehicle in CARLA with its own sensors: perception runs beside the loop, and the world is as perceived."""

from stucksolver_perception.carla.ego_perception import EgoPerception
from stucksolver_perception.carla.perceived_ego import PerceivedEgo
from stucksolver_perception.carla.sensor_faults import FAULTS, SensorFault

__all__ = ["FAULTS", "EgoPerception", "PerceivedEgo", "SensorFault"]
