"""A vehicle in CARLA that sees by its own sensors: perception runs beside the loop, and the world is as sensed."""

from stucksolver.stacks.sensed.eyes import Eyes
from stucksolver.stacks.sensed.faults import FAULTS, SensorFault
from stucksolver.stacks.sensed.mounting import SensorError
from stucksolver.stacks.sensed.vehicle import SensedVehicle

__all__ = ["FAULTS", "Eyes", "SensedVehicle", "SensorError", "SensorFault"]
