"""What is to be recorded of a drive."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stucksolver.perception.rig import SHIPPED


@dataclass(frozen=True)
class RecordingSpec:
    """Asked of one drive; goes to another process with its job."""

    folder: Path
    """Of this recording alone."""
    rig_file: Path = SHIPPED
    every_s: float = 1.0
    """A window of consecutive ticks is kept so often, its last tick with a picture; 0 keeps all ticks, and a picture
    every 0.5 s."""
    window_ticks: int = 12
    """How many sweeps a detector may join: half a second of them, and one more."""
    weather: str = ""
    """What its weather is called, for whoever sorts recordings."""
    crowd: bool = False
    """Strew vehicles, people, animals and things along the route."""
