"""Flagger."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement

FLAGGER, CONE, SIGN = "walker.flagger.0001", "static.prop.trafficcone01", "static.prop.warningconstruction"
LASTS_S = 30.0
"""Time until the flagger shows go (s)."""


@scenario
class Flagger(StuckScenario):
    """A flagger at a work site stops the hero, then waves it through: wait for the sign."""

    type = "Flagger"
    placed = SuitePlacement("immobilized", 3170, LaneSites(two_ways), {"distance": IntegerDraw(40, 48)})
    driver_alone = "completed: waits 30 s"
    expected = "wait"
    suspends = frozenset({"blocked"})
    starts = "the flagger shows stop from the start, and go 30 s after the hero came within 25 m"
    simplified = "when the flagger shows go, the flagger is at the roadside and the cones are gone"
    blueprints = (FLAGGER, CONE, SIGN)

    def stage(self) -> None:
        half_m = self.ahead(self.distance_m).lane_width / 2.0
        self._stop = self.spawn_at(FLAGGER, 0.0, 0.4, turn_deg=180.0, gesture="stop")
        self._cones = [self.spawn_at(CONE, 3.0, share * half_m) for share in (-0.7, 0.0, 0.7)]
        self.spawn_at(SIGN, -12.0, half_m + 0.8, turn_deg=180.0)

    def situation(self) -> Iterator[None]:
        yield from self.hero_near()
        yield from self.wait(LASTS_S)
        self.cast.remove([self._stop, *self._cones])
        yield
        aside_m = self.ahead(self.distance_m).lane_width / 2.0 + 0.7
        self.spawn_at(FLAGGER, 0.0, aside_m, turn_deg=180.0, gesture="go")
