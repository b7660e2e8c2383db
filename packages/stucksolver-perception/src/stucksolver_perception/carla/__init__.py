"""Provides sensor-based perception for a vehicle in CARLA: perception runs in a thread parallel to the control loop."""

from stucksolver_perception.carla.ego_perception import EgoPerception
from stucksolver_perception.carla.perceived_ego import PerceivedEgo
from stucksolver_perception.carla.sensor_faults import FAULTS, SensorFault

__all__ = ["FAULTS", "EgoPerception", "PerceivedEgo", "SensorFault"]
