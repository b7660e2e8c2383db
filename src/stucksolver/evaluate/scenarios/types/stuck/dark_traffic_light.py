"""DarkTrafficLight."""

from __future__ import annotations

from collections.abc import Iterator

import carla

from stucksolver.evaluate.scenarios.moves.stuck import StuckAtLight
from stucksolver.evaluate.scenarios.registry import scenario


@scenario
class DarkTrafficLight(StuckAtLight):
    """All lights of the junction are dark: it is an all-way stop; stop, creep, yield, go."""

    type = "DarkTrafficLight"
    expected = "recover"
    suspends = frozenset({"blocked"})

    def happen(self) -> Iterator[None]:
        for light in self.lights:
            light.set_state(carla.TrafficLightState.Off)
        self.lights[0].freeze(True)
        self._held = True
        yield
