"""The attributes that the camera can read from an object."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.scene import ObjectKind
from stucksolver.scene.objects import Gesture
from stucksolver_perception.measurements import Floats


@dataclass(frozen=True, eq=False)
class Attributes:
    """What is known of one object; None for everything that is not certain enough."""

    kind: ObjectKind | None = None
    kind_confidence: float = 0.0
    """Confidence of the likeliest kind, reported or not; 0 if the object was not looked at."""
    kind_shares: Floats | None = None
    """(len(KINDS),) probabilities, for voting; None if the object was not looked at."""
    hidden: bool | None = None
    """True: the box shows something else, or nothing."""
    brake_lights: bool | None = None
    left_blinker: bool | None = None
    """In a single image: whether it is lit now. In a memory: whether it blinks."""
    right_blinker: bool | None = None
    emergency_lights: bool | None = None
    door_open: bool | None = None
    gesture: Gesture | None = None
    """Of a flagger; None for all others."""

    @property
    def hazard_lights(self) -> bool | None:
        """True if both blinkers blink; False as soon as one is known to be off."""
        both = (self.left_blinker, self.right_blinker)
        return False if False in both else (True if all(both) else None)
