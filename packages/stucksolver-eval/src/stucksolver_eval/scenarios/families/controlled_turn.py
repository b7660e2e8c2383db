"""Junctions with lights and signs only."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.junction import JunctionScenario

BEYOND_M = 10.0
"""Distance after the junction at which the scenario ends (m)."""
FIRST_S = 5.0
"""Duration of the first color (s)."""


class PlainTurn(JunctionScenario):
    """Base: nothing is spawned; the scenario ends 10 m after the junction."""

    # The public types have the time limit's criterion but no timer, so the test for being blocked applies.
    timeout_s = None
    starts = "nothing happens; lights and signs are unchanged"

    def script(self) -> Iterator[None]:
        yield from self.until_passed(self.exit_s + BEYOND_M)


class LitTurn(PlainTurn):
    """Base: the lights of the junction are controlled while the hero approaches."""

    needs_map = "a junction on the route whose lights stop the hero"
    lit: ClassVar[str] = "green"

    def needs(self, setting: ScenarioContext) -> str | None:
        missing = super().needs(setting)
        if missing is None and not self.own_lights:
            missing = "the hero has no traffic light at its next junction"
        return missing

    def script(self) -> Iterator[None]:
        end = self._lights()
        for _ in self.until_passed(self.exit_s + BEYOND_M):
            next(end, None)
            yield
        self.free_lights()

    def _lights(self) -> Iterator[None]:
        """Script: control the hero's light: one color first, then the other."""
        own: list[Any] = list(self.own_lights)
        self.hold_lights(green=own if self.lit == "green" else [])
        yield from self.wait(FIRST_S)
        self.hold_lights(green=[] if self.lit == "green" else own)
        if self.lit == "green":
            yield from self.wait(FIRST_S)
            self.free_lights()
