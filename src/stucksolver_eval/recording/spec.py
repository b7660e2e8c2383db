"""What to record of a drive."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stucksolver.perception.rig import SHIPPED


@dataclass(frozen=True)
class RecordingSpec:
    """What to record of one drive; it is passed to another process with the job."""

    folder: Path
    """Folder of this recording alone."""
    rig_file: Path = SHIPPED
    every_s: float = 1.0
    """Interval between windows of consecutive ticks (s); the last tick of each has an image. 0 keeps all ticks, with an
    image every 0.5 s."""
    window_ticks: int = 12
    """Length of a window: the sweeps that a detector may join, which are half a second, and one or two more."""
    weather: str = ""
    """Name of the weather, for sorting recordings."""
    crowd: bool = False
    """Scatter vehicles, people, animals and objects along the route."""
