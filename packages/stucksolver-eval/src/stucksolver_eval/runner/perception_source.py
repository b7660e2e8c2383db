"""The perception of a run's ego: the client's ground truth, or its own sensors, with one interface."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.systems.spec import SENSORS

if TYPE_CHECKING:
    import carla

FAULT_FROM_S = 8.0
"""Time at which a sensor fault starts (s). Ours."""


class PerceptionSource(Protocol):
    """The interface of a perception; `stucksolver_perception.carla.EgoPerception` implements it."""

    vehicle: Any
    """The ego as driver and solver perceive it."""

    def tick(self) -> None:
        """Update; called once after each tick of the world."""

    def checked(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """Return the control that may be applied."""

    def close(self) -> None:
        """Release all resources at the end of the run."""


class GroundTruthSource:
    """The client's ground truth, which needs no sensors and cannot fail."""

    def __init__(self, hero: carla.Vehicle) -> None:
        self.vehicle = hero

    def tick(self) -> None:
        """Do nothing: there are no sensors."""

    def checked(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """Return the control unchanged."""
        return control

    def close(self) -> None:
        """Do nothing."""


def knowledge_of(job: RouteJob, hero: carla.Vehicle, carla_map: carla.Map) -> PerceptionSource:
    """Return the perception of the job's system. Raises the errors of `EgoPerception`."""
    if job.arm.perception != SENSORS:
        return GroundTruthSource(hero)
    # The import is here because only this needs the networks and their libraries.
    from stucksolver_perception.carla import EgoPerception, SensorFault

    fault = SensorFault(job.arm.sensor_fault, FAULT_FROM_S, job.seed) if job.arm.sensor_fault else None
    return EgoPerception(hero, carla_map, seed=job.seed, fault=fault)
