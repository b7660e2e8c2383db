"""By what the ego of a drive knows the world: the client's word, or its own sensors; a drive asks both alike."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from stucksolver_eval.arms.spec import SENSORS
from stucksolver_eval.runner.job import RouteJob

if TYPE_CHECKING:
    import carla

FAULT_FROM_S = 8.0
"""A sensor that is to fail does so when the drive has begun."""


class KnowsWorld(Protocol):
    """See `stucksolver.stacks.sensed.Eyes`, which is one."""

    vehicle: Any
    """The ego as those know it who drive and who help."""

    def tick(self) -> None:
        """Called once after each tick of the world."""

    def checked(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """What may be applied of a control."""

    def close(self) -> None:
        """The drive is over."""


class ClientTruth:
    """The client's ground truth: nothing is to be read, and nothing can fail."""

    def __init__(self, hero: carla.Vehicle) -> None:
        self.vehicle = hero

    def tick(self) -> None:
        """There are no sensors."""

    def checked(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """All of it."""
        return control

    def close(self) -> None:
        """Nothing is held."""


def knowledge_of(job: RouteJob, hero: carla.Vehicle, carla_map: carla.Map) -> KnowsWorld:
    """As the job's arm says. Raises what `Eyes` raises."""
    if job.arm.perception != SENSORS:
        return ClientTruth(hero)
    # Only here are the networks and their libraries needed.
    from stucksolver.stacks.sensed import Eyes, SensorFault

    fault = SensorFault(job.arm.sensor_fault, FAULT_FROM_S, job.seed) if job.arm.sensor_fault else None
    return Eyes(hero, carla_map, seed=job.seed, fault=fault)
