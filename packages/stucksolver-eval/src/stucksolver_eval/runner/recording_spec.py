"""Settings for recording a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from stucksolver_perception.rig import SHIPPED


@dataclass(frozen=True)
class RecordingSpec:
    """Settings for recording one run. They are passed to another process with the job."""

    folder: Path
    """Folder of this recording alone."""
    rig_file: Path = SHIPPED
    every_s: float = 1.0
    """Interval between windows of consecutive ticks (s). The last tick of each window has an image.

    0 records all ticks, with an image every 0.5 s.
    """
    window_ticks: int = 12
    """Length of a window (ticks): the sweeps that a detector may join, which are half a second, and one or two more.

    Ours.
    """
    weather: str = ""
    """Name of the weather, for sorting recordings."""
    factory: str = ""
    """`MODULE:FUNCTION` that returns the recorder: `function(spec, context, seed, facts)`. See `DriveRecorder`."""
    crowd: str = ""
    """`MODULE:FUNCTION` that scatters vehicles, pedestrians, animals and objects along the route.

    Its signature is `function(context, seed)`.
    """


class TickPart(Protocol):
    """A part of a run that is called on every tick."""

    def tick(self, time_s: float) -> None:
        """Run the part's actions for this simulation time (s)."""


class Recording(Protocol):
    """Records one drive."""

    def tick(self) -> None:
        """Record this tick, if it is due."""

    def close(self) -> None:
        """End the recording."""
