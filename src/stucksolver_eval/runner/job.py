"""One route to be driven by one arm, with everything that another process needs to do it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from stucksolver_eval.aboard import PassengerSpec
from stucksolver_eval.arms.spec import ArmSpec
from stucksolver_eval.guidance.script import Line
from stucksolver_eval.recording.spec import RecordingSpec
from stucksolver_eval.routes import Route

Replays = Literal["none", "failed", "all"]


@dataclass(frozen=True)
class RouteJob:
    """`host`, `port`: a running CARLA server instead of a carlette of our own.

    `background`: whether there is traffic beside what the route's scenarios bring. `limit_s`: the route ends then.
    `events`: all events of the solver are kept. `frame_every_s`: between two frames of the replay.
    """

    route: Route
    seed: int
    arm: ArmSpec
    lines: tuple[Line, ...] = ()
    maps: str | None = None
    replays: Replays = "none"
    records: Path | None = None
    """Where the records of its interventions go."""
    background: bool = True
    limit_s: float | None = None
    events: bool = False
    frame_every_s: float = 0.2
    recording: RecordingSpec | None = None
    """Sensors' data and the truth are kept of the drive, to train perception on."""
    passenger: PassengerSpec | None = None
    """People talk to the car meanwhile, where StuckSolver helps: it is driven at the pace of the clock on the wall."""
    host: str | None = None
    port: int = 2000

    @property
    def scenario(self) -> str:
        """The type that the route is about; its first scenario, as the benchmark has it."""
        return self.route.scenarios[0].type if self.route.scenarios else "None"
