"""The base class of scenarios: a situation that is staged at the start of the route, and a script with a trigger."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from functools import cached_property
from random import Random
from typing import Any, ClassVar, Literal

import carla

from stucksolver_eval.actors import ActorPool, ActorState, SimulatedCars
from stucksolver_eval.background_traffic import Background
from stucksolver_eval.routes.route import ScenarioSpec
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.sites.suite_placement import SuitePlacement

Expected = Literal["recover", "wait", "ask", "reroute", "leave"]
LONG_S = 240.0
"""The time limit of most types (s). As in scenario_runner."""


class ScenarioError(ValueError):
    """A scenario cannot be played as specified. The message names the scenario and the remedy."""


class UnsupportedScenarioError(ScenarioError):
    """This map or blueprint library does not support the scenario, and nothing replaces it."""


class Scenario(ABC):
    """One situation. A type defines its name `type`, its parameters (see `parameters`), `stage` and `script`.

    The class's docstring describes the situation; `starts`, `simplified` and others complete the documentation.
    """

    type: ClassVar[str]
    timeout_s: ClassVar[float | None] = LONG_S
    """Time after which the scenario fails and ends (s). Until then, the test for being blocked is suspended."""
    placed: ClassVar[SuitePlacement | None] = None
    """Placement in the shipped suites; None for a type outside the suites."""
    driver_alone: ClassVar[str] = ""
    """Result of the driver alone (`behavior:normal`, seed 1) on one shipped route, from its replay."""
    starts: ClassVar[str] = "at the trigger point"
    """Time of the event to which the ego must react, for the documentation."""
    simplified: ClassVar[str] = ""
    """Differences from the public benchmark, for the documentation."""
    needs_map: ClassVar[str] = ""
    """Requirements on the map, for the documentation."""
    blueprints: ClassVar[tuple[str, ...]] = ()
    """Required blueprints."""
    expected: ClassVar[Expected | None] = None
    """The right reaction, if the scenario has one."""
    within_s: ClassVar[float | None] = None
    """Time for the right reaction (s), if it is limited. `metrics/right_reaction.py` says from when it counts."""
    suspends: ClassVar[frozenset[str]] = frozenset()
    """Criteria that are suspended while it runs."""
    extra_criteria: ClassVar[frozenset[str]] = frozenset()
    """Criteria that count twice while it runs."""
    keeps_suspended: ClassVar[frozenset[str]] = frozenset()
    """Criteria that stay suspended after its end."""

    def __init__(self, spec: ScenarioSpec, setting: ScenarioContext, traffic: Background | None = None) -> None:
        """Create the scenario on a route. `traffic` is the background. Without one, its hooks do nothing."""
        self.spec = spec
        self.setting = setting
        self._traffic = traffic
        self.suspended: set[str] = set()
        self.news: list[tuple[str, str, float]] = []
        """Events for the criteria since the last read by `ScenarioPlayer`: (kind, text, value)."""
        self.trigger_index = setting.route.project(_location(spec))
        self.trigger_s_m = float(setting.route.s_m[self.trigger_index])

    def needs(self, setting: ScenarioContext) -> str | None:
        """Return the reason why this map or blueprint library does not support it, or None."""
        return None

    def stage(self) -> None:  # noqa: B027 (many types have nothing to stage)
        """Spawn the actors that are present from the route's start, and stage the others below the ground."""

    @abstractmethod
    def script(self) -> Iterator[None]:
        """Run the scenario from the trigger on, with one `yield` per tick, until it is over."""

    def close(self) -> None:  # noqa: B027
        """Undo lasting effects, such as frozen lights. Called exactly once, in any state."""

    def disturb(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """Return the control for the vehicle in place of the hero's, while the script runs."""
        return control

    def perceived(self, vehicle: Any) -> Any:
        """Return the vehicle as driver and solver perceive it. A scenario about perception's errors replaces it."""
        return vehicle

    # ---- helpers for scripts

    @property
    def cast(self) -> ActorPool:
        """The actors of the run."""
        return self.setting.cast

    @property
    def cars(self) -> SimulatedCars:
        """The simulated cars."""
        return self.setting.cars

    @property
    def random(self) -> Random:
        """The route's random number generator."""
        return self.setting.random

    @property
    def hero(self) -> ActorState:
        """State of the vehicle under test."""
        return self.setting.cast.hero

    @cached_property
    def traffic(self) -> Background:
        """The background, or an empty one whose hooks do nothing."""
        return self._traffic or Background(self.setting, empty=True)

    @property
    def limit_mps(self) -> float:
        """The hero's speed limit (m/s)."""
        return max(float(self.setting.hero.get_speed_limit()), 10.0) / 3.6

    def s_at(self, distance_m: float) -> float:
        """Return the arc length `distance_m` beyond the trigger (m). Raises `ScenarioError` beyond the route's end."""
        s_m = self.trigger_s_m + distance_m
        if s_m > self.setting.route.length_m:
            raise ScenarioError(
                f"{self.spec.name}: the route ends less than {distance_m:.0f} m beyond the trigger point; "
                "extend the route or move the trigger point back"
            )
        return s_m

    def ahead(self, distance_m: float) -> carla.Waypoint:
        """Return the route waypoint `distance_m` beyond the trigger. Raises `ScenarioError` beyond the route's end."""
        return self.setting.route.waypoint_at(self.s_at(distance_m))

    def gap_m(self, s_m: float) -> float:
        """Return the distance along the route from the hero's center to arc length `s_m` (m)."""
        return s_m - self.setting.hero_s_m

    def within(self, s_m: float, seconds: float, distance_m: float) -> bool:
        """Return True if the hero is within this time or distance of arc length `s_m`, or beyond it."""
        gap_m = self.gap_m(s_m)
        return gap_m < distance_m or gap_m < seconds * max(self.hero.speed_mps, 0.0)

    def until(self, condition: Callable[[], bool]) -> Iterator[None]:
        """Script: wait until a condition holds."""
        while not condition():
            yield

    def wait(self, seconds: float) -> Iterator[None]:
        """Script: wait for a simulated time (s)."""
        end_s = self.cast.time_s + seconds - 1e-6
        while self.cast.time_s < end_s:
            yield

    def until_passed(self, s_m: float) -> Iterator[None]:
        """Script: wait until the hero has reached arc length `s_m` (m) or the route's end."""
        s_m = min(s_m, self.setting.route.length_m - 3.0)
        yield from self.until(lambda: self.setting.hero_s_m >= s_m)

    def at_route_end(self) -> bool:
        """Return True if the hero is at the end of its route."""
        return self.setting.hero_s_m >= self.setting.route.length_m - 3.0


def _location(spec: ScenarioSpec) -> carla.Location:
    place = spec.trigger.position
    return carla.Location(place.x_m, place.y_m, place.z_m)
