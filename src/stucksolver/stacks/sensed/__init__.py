"""A vehicle in CARLA with its own sensors: perception runs beside the loop, and the world is as perceived."""

from stucksolver.stacks.sensed.eyes import Eyes
from stucksolver.stacks.sensed.faults import FAULTS, SensorFault
from stucksolver.stacks.sensed.mounting import SensorError
from stucksolver.stacks.sensed.vehicle import SensedVehicle

__all__ = ["FAULTS", "Eyes", "SensedVehicle", "SensorError", "SensorFault"]
