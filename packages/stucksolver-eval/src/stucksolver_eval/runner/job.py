"""One route for one system, with everything that another process needs for it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from stucksolver_eval.guidance.script import ScriptLine
from stucksolver_eval.passenger import PassengerSpec
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.recording_spec import RecordingSpec
from stucksolver_eval.systems.spec import SystemSpec

Replays = Literal["none", "failed", "all"]


@dataclass(frozen=True)
class RouteJob:
    """One route, one system and one seed.

    Attributes:
        background: Add traffic in addition to the actors of the route's scenarios.
        limit_s: Simulated time after which the route ends.
        events: Store all events of the solver.
        frame_every_s: Time between two frames of the replay.
        host: Address of a running CARLA server, which replaces carlette.
        port: Its port.
    """

    route: Route
    seed: int
    arm: SystemSpec
    lines: tuple[ScriptLine, ...] = ()
    maps: str | None = None
    replays: Replays = "none"
    records: Path | None = None
    """Folder for the records of its interventions."""
    background: bool = True
    limit_s: float | None = None
    events: bool = False
    frame_every_s: float = 0.2
    recording: RecordingSpec | None = None
    """Settings for recording sensor data and ground truth, for training perception."""
    passenger: PassengerSpec | None = None
    """Connection to the passenger's page, for a system with StuckSolver. The run then takes real time."""
    host: str | None = None
    port: int = 2000

    @property
    def scenario(self) -> str:
        """Type of the route's first scenario, as in the benchmark."""
        return self.route.scenarios[0].type if self.route.scenarios else "None"
