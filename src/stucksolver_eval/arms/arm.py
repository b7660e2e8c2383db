"""What every arm is: asked for a control once a tick, and what it did is written down."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from stucksolver.decision import Directive
from stucksolver.stacks.driver import Driver
from stucksolver_eval.results.outcome import InterventionRecord, QueryRecord, Reliability, Spoken

if TYPE_CHECKING:
    import carla


@dataclass
class ArmLog:
    """What an arm did; times since the start of the route."""

    interventions: list[InterventionRecord] = field(default_factory=list)
    queries: list[QueryRecord] = field(default_factory=list)
    guidance: list[Spoken] = field(default_factory=list)
    asked_s: float | None = None
    reliability: list[Reliability] = field(default_factory=list)


@dataclass(frozen=True)
class Now:
    """The ego at this tick: time since the start, speed, and place along the route."""

    time_s: float
    speed_mps: float
    place_m: float


class Arm(Protocol):
    """Wraps a driver. `directive` is what the driver was told last, for the replay."""

    log: ArmLog
    directive: Directive | None

    def step(self, now: Now) -> carla.VehicleControl:
        """This tick's `carla.VehicleControl`."""

    def say(self, text: str) -> None:
        """A passenger's words."""

    def close(self, time_s: float) -> None:
        """The route is over."""


class DriverAlone:
    """Nobody helps."""

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self.log = ArmLog()
        self.directive: Directive | None = None

    def step(self, now: Now) -> carla.VehicleControl:
        """Lets the driver drive; there is nothing to tell."""
        control: carla.VehicleControl = self._driver.run_step()
        return control

    def say(self, text: str) -> None:
        """Nobody listens."""

    def close(self, time_s: float) -> None:
        """Nothing is left to do."""
