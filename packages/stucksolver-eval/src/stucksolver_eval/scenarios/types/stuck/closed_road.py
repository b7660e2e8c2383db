"""ClosedRoad."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from stucksolver_eval.scenarios.families.lane_places import row_across
from stucksolver_eval.scenarios.families.stuck import StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.stuck_sites import closed_streets
from stucksolver_eval.sites.suite_placement import SuitePlacement

BARRIER, SIGN = "static.prop.streetbarrier", "static.prop.warningconstruction"
SIGN_BEFORE_M = 2.0
"""Distance of the sign before the barriers (m)."""


@scenario
class ClosedRoad(StuckScenario):
    """The road is closed from curb to curb: leave the route and reach the destination another way."""

    type = "ClosedRoad"
    placed: ClassVar[SuitePlacement | None] = SuitePlacement("immobilized", 3140, closed_streets, only_in="grid_town")
    driver_alone = "stuck before the barrier"
    expected = "reroute"
    suspends = frozenset({"blocked", "route_deviation"})
    simplified = "no other vehicle drives into the closed road"
    needs_map = "another road from where the hero stops: in the suite the closed street starts at a junction"
    blueprints: ClassVar[tuple[str, ...]] = (BARRIER, SIGN)

    def script(self) -> Iterator[None]:
        self.traffic.handle_junction_scenario()
        self.traffic.switch_route_sources(False)
        self.traffic.remove_behind()
        # The script runs until the end of the drive, because a hero that replans follows another route from here.
        yield from self.until(lambda: False)

    def stage(self) -> None:
        for place in row_across(self.setting.map, self.ahead(self.distance_m)):
            self.cast.must_spawn(BARRIER, place, lift_m=0.0)
        self.spawn_at(SIGN, -SIGN_BEFORE_M, 0.0, turn_deg=180.0)
