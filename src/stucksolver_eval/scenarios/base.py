"""What every scenario is: a situation staged at the start of the route, and a script that runs from a trigger on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from functools import cached_property
from random import Random
from typing import ClassVar, Literal

import carla

from stucksolver_eval.actors import ActorPool, ActorState, Cars
from stucksolver_eval.background import Background
from stucksolver_eval.routes.route import ScenarioSpec
from stucksolver_eval.setting import Setting
from stucksolver_eval.sites.placed import Placed

Expected = Literal["recover", "wait", "ask", "reroute"]
LONG_S = 240.0
"""The time limit of most types."""


class ScenarioError(ValueError):
    """A scenario cannot be played as its specification says; the message names it and the remedy."""


class Unsupported(ScenarioError):
    """This map or blueprint library cannot host the scenario; nothing is put in its place."""


class Scenario(ABC):
    """One situation. A type states its `type`, its parameters (see `parameters`), `stage` and `script`.

    The class's docstring says what the situation is; `trigger` and `simplified` complete the documentation.
    """

    type: ClassVar[str]
    timeout_s: ClassVar[float | None] = LONG_S
    """After this time the scenario counts as failed and ends; while it runs, the test for being blocked is off."""
    placed: ClassVar[Placed | None] = None
    """Where the shipped suites put it; None: in none of them."""
    driver_alone: ClassVar[str] = ""
    """What became of the driver alone (`behavior:normal`, seed 1) on one shipped route, as seen in its replay."""
    starts: ClassVar[str] = "at the trigger point"
    """When what the ego has to react to happens, for the documentation."""
    simplified: ClassVar[str] = ""
    """How it differs from the public benchmark's, for the documentation."""
    needs_map: ClassVar[str] = ""
    """What the map must have, for the documentation."""
    blueprints: ClassVar[tuple[str, ...]] = ()
    """Blueprints it cannot do without."""
    expected: ClassVar[Expected | None] = None
    """What is right here, where a scenario is judged by that."""
    suspends: ClassVar[frozenset[str]] = frozenset()
    """Criteria that are off while it runs."""
    extra_criteria: ClassVar[frozenset[str]] = frozenset()
    """Criteria that count a second time while it runs."""
    keeps_suspended: ClassVar[frozenset[str]] = frozenset()
    """Criteria that stay off after the end, once it has switched them off."""

    def __init__(self, spec: ScenarioSpec, setting: Setting, traffic: Background | None = None) -> None:
        """`traffic`: the background; without one its hooks do nothing."""
        self.spec = spec
        self.setting = setting
        self._traffic = traffic
        self.suspended: set[str] = set()
        self.news: list[tuple[str, str, float]] = []
        """(kind, text, value) since `Play` last looked: what the criteria should know."""
        self.trigger_index = setting.route.project(_location(spec))
        self.trigger_s_m = float(setting.route.s_m[self.trigger_index])

    def needs(self, setting: Setting) -> str | None:
        """Why this map or blueprint library cannot host it, or None."""
        return None

    def stage(self) -> None:  # noqa: B027 (many types have nothing to stage)
        """At the start of the route: spawn what must be there, and keep the rest below the ground."""

    @abstractmethod
    def script(self) -> Iterator[None]:
        """From the trigger on, one `yield` a tick; it returns when the scenario is over."""

    def close(self) -> None:  # noqa: B027
        """Undo what outlives the script: lights held, criteria off. Called once, whatever happened before."""

    def disturb(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """The hero's `carla.VehicleControl` as the vehicle gets it, while the script runs."""
        return control

    # What scripts read and use.

    @property
    def cast(self) -> ActorPool:
        """The actors of the route."""
        return self.setting.cast

    @property
    def cars(self) -> Cars:
        """The cars that drive by themselves."""
        return self.setting.cars

    @property
    def random(self) -> Random:
        """The route's source of chance."""
        return self.setting.random

    @property
    def hero(self) -> ActorState:
        """The vehicle under test."""
        return self.setting.cast.hero

    @cached_property
    def traffic(self) -> Background:
        """The background, or an empty one whose hooks do nothing."""
        return self._traffic or Background(self.setting, empty=True)

    @property
    def limit_mps(self) -> float:
        """Speed limit of the hero."""
        return max(float(self.setting.hero.get_speed_limit()), 10.0) / 3.6

    def s_at(self, distance_m: float) -> float:
        """Arc length of a place so far beyond the trigger. Raises `ScenarioError` beyond the route's end."""
        s_m = self.trigger_s_m + distance_m
        if s_m > self.setting.route.length_m:
            raise ScenarioError(
                f"{self.spec.name}: {distance_m:.0f} m beyond the trigger point the route has ended; "
                "extend the route or move the trigger point back"
            )
        return s_m

    def ahead(self, distance_m: float) -> carla.Waypoint:
        """The route's `carla.Waypoint` so far beyond the trigger. Raises `ScenarioError` beyond the route's end."""
        return self.setting.route.at(self.s_at(distance_m))

    def gap_m(self, s_m: float) -> float:
        """How far along the route a place is still ahead of the hero's middle."""
        return s_m - self.setting.hero_s_m

    def within(self, s_m: float, seconds: float, distance_m: float) -> bool:
        """Whether the hero is so many seconds or metres from a place of the route, or beyond it."""
        gap_m = self.gap_m(s_m)
        return gap_m < distance_m or gap_m < seconds * max(self.hero.speed_mps, 0.0)

    def until(self, condition: Callable[[], bool]) -> Iterator[None]:
        """Wait for something."""
        while not condition():
            yield

    def wait(self, seconds: float) -> Iterator[None]:
        """Wait for a time."""
        end_s = self.cast.time_s + seconds - 1e-6
        while self.cast.time_s < end_s:
            yield

    def until_passed(self, s_m: float) -> Iterator[None]:
        """Wait until the hero is at a place of the route, or at the route's end."""
        s_m = min(s_m, self.setting.route.length_m - 3.0)
        yield from self.until(lambda: self.setting.hero_s_m >= s_m)

    def at_route_end(self) -> bool:
        """Whether the hero is at the end of its route, where nothing can follow any more."""
        return self.setting.hero_s_m >= self.setting.route.length_m - 3.0


def _location(spec: ScenarioSpec) -> carla.Location:
    place = spec.trigger.position
    return carla.Location(place.x_m, place.y_m, place.z_m)
