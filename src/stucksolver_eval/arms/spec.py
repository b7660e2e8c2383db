"""Who drives, who helps, and how time is counted: what an arm is made from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

PRIVILEGED = "privileged"
"""Driver and helper know the world from the simulator's ground truth."""
SENSORS = "sensors"
"""They know it from the rig's sensors."""


@dataclass(frozen=True)
class ArmSpec:
    """Who drives, who helps, and how time is counted.

    `recovery`: `none`, `timers`, or the reasoner of the ladder's rung `rules`, such as `rules` or `faulty:random`.
    `reasoner`: the one of its rung `model`, if any. `detector`: fields of `DetectorSettings` that differ from
    its defaults. `guarded`: False drives what is proposed without a proof, to see what the guard is worth.
    `heedless`: while it drives a plan the driver brakes for nobody by itself, to see what the guard alone is worth.
    """

    driver: str = "behavior:normal"
    recovery: str = "none"
    reasoner: str = ""
    clock: str = "lockstep"
    perception: str = PRIVILEGED
    sensor_fault: str = ""
    """Experiment: a sensor that fails on the way, one of `stucksolver.stacks.sensed.FAULTS`."""
    ladder: Path | None = None
    memory: Path | None = None
    """File of the memory of what helped, which stands before the recovery; None: nothing is remembered."""
    detector: dict[str, float] = field(default_factory=dict)
    guarded: bool = True
    heedless: bool = False
    camera: bool = False
    """The front camera is carried even where no reasoner looks at it, to show what was seen."""

    @property
    def name(self) -> str:
        """What tables call it."""
        if self.sensor_fault:
            return f"{replace(self, sensor_fault='').name}, {self.sensor_fault}"
        if self.recovery == "none":
            return "driver alone"
        helped = f"{self.recovery} + {self.reasoner}" if self.reasoner else self.recovery
        helped += "" if self.memory is None else " + memory"
        return helped + (", heedless" if self.heedless else "") + ("" if self.guarded else ", unguarded")
