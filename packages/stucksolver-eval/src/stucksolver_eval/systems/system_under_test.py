"""The interface of every system under test: it returns one control per tick, and its actions are logged."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from stucksolver.plan import Directive
from stucksolver_carla.drivers.behavior import Driver
from stucksolver_eval.results.outcome import InterventionRecord, NoticeRecord, QueryRecord, Reliability, SpokenGuidance

if TYPE_CHECKING:
    import carla


@dataclass
class SystemLog:
    """The log of a system; times since the start of the route (s)."""

    interventions: list[InterventionRecord] = field(default_factory=list)
    queries: list[QueryRecord] = field(default_factory=list)
    guidance: list[SpokenGuidance] = field(default_factory=list)
    asked_s: float | None = None
    notices: list[NoticeRecord] = field(default_factory=list)
    reliability: list[Reliability] = field(default_factory=list)


@dataclass(frozen=True)
class TickInfo:
    """The ego at this tick: time since the start, speed, and position along the route."""

    time_s: float
    speed_mps: float
    place_m: float


class SystemUnderTest(Protocol):
    """Wraps a driver. `directive` is the last directive to the driver, for the replay."""

    log: SystemLog
    directive: Directive | None

    def step(self, now: TickInfo) -> carla.VehicleControl:
        """Return this tick's `carla.VehicleControl`."""

    def say(self, text: str) -> None:
        """Receive a passenger's utterance."""

    def close(self, time_s: float) -> None:
        """End the route."""


class DriverOnly:
    """The driver without recovery."""

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self.log = SystemLog()
        self.directive: Directive | None = None

    def step(self, now: TickInfo) -> carla.VehicleControl:
        """Let the driver drive."""
        control: carla.VehicleControl = self._driver.run_step()
        return control

    def say(self, text: str) -> None:
        """Ignore the utterance."""

    def close(self, time_s: float) -> None:
        """Do nothing."""
