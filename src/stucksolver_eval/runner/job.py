"""One route to be driven by one arm, with everything that another process needs to do it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from stucksolver_eval.guidance.script import Line
from stucksolver_eval.routes import Route

Replays = Literal["none", "failed", "all"]


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
    perception: str = "privileged"
    ladder: Path | None = None
    detector: dict[str, float] = field(default_factory=dict)
    guarded: bool = True
    heedless: bool = False
    camera: bool = False
    """The front camera is carried even where no reasoner looks at it, to show what was seen."""

    @property
    def name(self) -> str:
        if self.recovery == "none":
            return "driver alone"
        helped = f"{self.recovery} + {self.reasoner}" if self.reasoner else self.recovery
        return helped + (", heedless" if self.heedless else "") + ("" if self.guarded else ", unguarded")


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
    host: str | None = None
    port: int = 2000

    @property
    def scenario(self) -> str:
        """The type that the route is about; its first scenario, as the benchmark has it."""
        return self.route.scenarios[0].type if self.route.scenarios else "None"
