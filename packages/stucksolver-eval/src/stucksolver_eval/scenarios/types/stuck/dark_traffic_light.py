"""DarkTrafficLight."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.deadlock import Deadlock
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.stuck_sites import dark_lights
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class DarkTrafficLight(Deadlock):
    """All lights of a junction are dark, so it is an all-way stop, and all vehicles wait: creep, yield, go."""

    type = "DarkTrafficLight"
    placed = SuitePlacement("immobilized", 3070, dark_lights)
    driver_alone = "stuck before the nose in its path"
    expected = "recover"
    suspends = frozenset({"blocked"})
    needs_map = f"{Deadlock.needs_map}, with lights that stop the hero"

    def needs(self, setting: ScenarioContext) -> str | None:
        missing = super().needs(setting)
        if missing is None and not self.own_lights:
            missing = "the hero has no traffic light at its next junction"
        return missing

    def script(self) -> Iterator[None]:
        for light in self.lights:
            light.set_state(carla.TrafficLightState.Off)
        self.lights[0].freeze(True)
        self._held = True
        yield from super().script()
        self.free_lights()
