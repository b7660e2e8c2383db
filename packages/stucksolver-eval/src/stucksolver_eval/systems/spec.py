"""The specification of a system under test: the driver, the recovery, and the clock."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

PRIVILEGED = "privileged"
"""Driver and recovery use the simulator's ground truth."""
SENSORS = "sensors"
"""They use the rig's sensors."""


@dataclass(frozen=True)
class SystemSpec:
    """The driver, the recovery, and the clock.

    Attributes:
        driver: Name of the driver.
        recovery: `none`, `timers`, or the first reasoner on the ladder, such as `search` or `faulty:random`.
        reasoner: The reasoner of the ladder's rung `model`, if any.
        detector: Fields of `DetectorSettings` that differ from its defaults.
        guarded: False executes proposals without a proof, to measure the value of the guard.
        heedless: While it drives a plan the driver does not brake for other road users, to measure the guard alone.
    """

    driver: str = "behavior:normal"
    recovery: str = "none"
    reasoner: str = ""
    clock: str = "lockstep"
    perception: str = PRIVILEGED
    sensor_fault: str = ""
    """Experiment: a sensor that fails during the drive, one of `stucksolver_perception.carla.FAULTS`."""
    ladder: Path | None = None
    memory: Path | None = None
    """File of the memory that wraps the recovery; None for no memory."""
    detector: dict[str, float] = field(default_factory=dict)
    guarded: bool = True
    heedless: bool = False
    camera: bool = False
    """Carry the front camera even if no reasoner uses it, for the replay."""

    @property
    def name(self) -> str:
        """Name in tables."""
        if self.sensor_fault:
            return f"{replace(self, sensor_fault='').name}, {self.sensor_fault}"
        if self.recovery == "none":
            return "driver alone"
        helped = f"{self.recovery} + {self.reasoner}" if self.reasoner else self.recovery
        helped += "" if self.memory is None else " + memory"
        return helped + (", heedless" if self.heedless else "") + ("" if self.guarded else ", unguarded")
