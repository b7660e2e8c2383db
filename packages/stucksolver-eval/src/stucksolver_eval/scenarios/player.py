"""Plays the scenarios of a route: starts each at its trigger, runs its script, and ends it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stucksolver_eval.background_traffic import Background
from stucksolver_eval.routes.route import ScenarioSpec
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.registry import scenario_type
from stucksolver_eval.scenarios.scenario import Expected, Scenario, ScenarioError, UnsupportedScenarioError

if TYPE_CHECKING:
    import carla

TRIGGER_M = 2.0
"""Distance before a trigger point at which its scenario starts (m). As in the leaderboard."""
OFF_ROUTE_M = 10.0
"""Largest distance of a trigger point from the route (m). Ours."""


@dataclass(frozen=True)
class PlayEvent:
    """An event for the criteria and the log, at a time since the start (s).

    Kinds are `started`, `ended`, `mark`, `scenario_timeout` and `yield_emergency_vehicle`, whose value is 1 if the ego
    yielded, else 0.
    """

    time_s: float
    kind: str
    scenario: str
    text: str
    value: float


@dataclass
class _Part:
    scenario: Scenario
    script: Iterator[None] | None = None
    started_s: float = 0.0
    over: bool = False


class ScenarioPlayer:
    """All scenarios of one route and the background traffic. It reads and writes the world once per tick.

    Raises:
        ScenarioError: A type does not exist, a parameter is invalid, or a trigger point is not on the route.
        UnsupportedScenarioError: The map or the blueprint library does not support a scenario.
    """

    def __init__(
        self, specs: Sequence[ScenarioSpec], setting: ScenarioContext, background: Background | None = None
    ) -> None:
        self._setting = setting
        self._background = background
        self._closed = False
        self.events: list[PlayEvent] = []
        setting.cast.take_snapshot()
        self._parts = [_Part(_built(spec, setting, background)) for spec in specs]
        for part in self._parts:
            part.scenario.stage()
        if background is not None:
            background.populate()
        setting.cast.flush()

    @property
    def active(self) -> frozenset[str]:
        """Types of the scenarios that are running."""
        return frozenset(part.scenario.type for part in self._running)

    @property
    def finished(self) -> bool:
        """True if all scenarios are over."""
        return all(part.over for part in self._parts)

    @property
    def expected(self) -> Expected | None:
        """The right reaction of the first scenario with one, or None."""
        return next((p.scenario.expected for p in self._parts if p.scenario.expected is not None), None)

    @property
    def within_s(self) -> float | None:
        """Time for the right reaction (s), or None."""
        return next((p.scenario.within_s for p in self._parts if p.scenario.within_s is not None), None)

    @property
    def marks(self) -> dict[str, float]:
        """First times of the scenarios' marks since the start (s)."""
        return {event.text: event.time_s for event in reversed(self.events) if event.kind == "mark"}

    def perceived(self, vehicle: Any) -> Any:
        """Return the vehicle as driver and solver perceive it."""
        for part in self._parts:
            vehicle = part.scenario.perceived(vehicle)
        return vehicle

    @property
    def suspended(self) -> frozenset[str]:
        """Criteria that are suspended now: `blocked`, `wrong_lane`, `route_deviation` and others."""
        off = {name for part in self._parts for name in part.scenario.suspended}
        if any(part.scenario.timeout_s is not None for part in self._running):
            off.add("blocked")
        return frozenset(off)

    @property
    def extra_criteria(self) -> frozenset[str]:
        """Criteria that count twice now: `collision` in `VehicleTurningRoutePedestrian`."""
        return frozenset(name for part in self._running for name in part.scenario.extra_criteria)

    def tick(self, time_s: float, hero_s_m: float) -> None:
        """Run scenarios and background. Call it after each tick of the world, before the driver's step.

        Args:
            time_s: Time since the start (s).
            hero_s_m: The hero's arc length on the route (m).
        """
        setting = self._setting
        setting.hero_s_m = hero_s_m
        setting.cast.take_snapshot()
        for part in self._parts:
            if part.script is None and not part.over and hero_s_m >= part.scenario.trigger_s_m - TRIGGER_M:
                self._start(part, time_s)
            if part.script is not None and not part.over:
                self._go_on(part, part.script, time_s)
        if self._background is not None:
            self._background.tick(time_s, hero_s_m)
        setting.cars.step()
        setting.cast.flush()

    def noise(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """Return the control for the vehicle in place of the hero's: `ControlLoss` disturbs it."""
        for part in self._running:
            control = part.scenario.disturb(control)
        return control

    def close(self) -> None:
        """End all scenarios and destroy the actors. Repeated calls do nothing."""
        if self._closed:
            return
        self._closed = True
        for part in self._parts:
            part.scenario.close()
        self._setting.cast.close()

    @property
    def _running(self) -> list[_Part]:
        return [part for part in self._parts if part.script is not None and not part.over]

    def _start(self, part: _Part, time_s: float) -> None:
        part.script, part.started_s = part.scenario.script(), time_s
        part.scenario.suspended |= part.scenario.suspends
        self._note(time_s, part, "started", f"{part.scenario.type} begins", 0.0)

    def _go_on(self, part: _Part, script: Iterator[None], time_s: float) -> None:
        ran_s = time_s - part.started_s
        limit_s = part.scenario.timeout_s
        late = limit_s is not None and ran_s > limit_s
        done = late or _is_over(script)
        for kind, text, value in part.scenario.news:
            self._note(time_s, part, kind, text, value)
        part.scenario.news.clear()
        if late:
            self._note(
                time_s, part, "scenario_timeout", f"{part.scenario.type} took longer than {limit_s:.0f} s", ran_s
            )
        if done:
            part.over = True
            part.scenario.suspended &= part.scenario.keeps_suspended
            self._note(time_s, part, "ended", f"{part.scenario.type} is over", ran_s)

    def _note(self, time_s: float, part: _Part, kind: str, text: str, value: float) -> None:
        self.events.append(PlayEvent(time_s, kind, part.scenario.spec.name, text, value))


def _is_over(script: Iterator[None]) -> bool:
    try:
        next(script)
    except StopIteration:
        # A script ends with this exception.
        return True
    return False


def _built(spec: ScenarioSpec, setting: ScenarioContext, background: Background | None) -> Scenario:
    scenario = scenario_type(spec.type)(spec, setting, background)
    place = setting.route.waypoints[scenario.trigger_index].transform.location
    trigger = spec.trigger.position
    off_m = ((place.x - trigger.x_m) ** 2 + (place.y - trigger.y_m) ** 2) ** 0.5
    if off_m > OFF_ROUTE_M:
        raise ScenarioError(
            f"{spec.name}: the trigger point ({trigger.x_m:.1f}, {trigger.y_m:.1f}) is {off_m:.0f} m off the route; "
            "move it onto the route"
        )
    missing = [blueprint for blueprint in scenario.blueprints if not setting.cast.knows(blueprint)]
    reason = f"the blueprint library has no {', '.join(missing)}" if missing else scenario.needs(setting)
    if reason is not None:
        raise UnsupportedScenarioError(f"{spec.name} ({spec.type}) is unsupported here: {reason}")
    return scenario
