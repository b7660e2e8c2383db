"""AmbulanceBehind."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver_eval.actors.actor_pool import lamps
from stucksolver_eval.background_traffic.lanes import back
from stucksolver_eval.scenarios.families.stuck import PASSABLE_M, StuckScenario
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import two_ways
from stucksolver_eval.sites.stuck_sites import to_pass
from stucksolver_eval.sites.suite_placement import SuitePlacement

AMBULANCE, CAR = "vehicle.ford.ambulance", "vehicle.lincoln.mkz_2020"
BEHIND_M = 45.0
"""Distance of the ambulance behind the hero (m)."""
STANDING_MPS = 0.5
"""Speed below which the hero counts as stopped (m/s)."""
SPEED_MPS = 12.0
"""Speed of the ambulance (m/s)."""


@scenario
class AmbulanceBehind(StuckScenario):
    """The hero is stopped behind a broken-down car when an ambulance arrives from behind: clear its path."""

    type = "AmbulanceBehind"
    placed = SuitePlacement("immobilized", 3180, to_pass(two_ways))
    driver_alone = "stuck, with the ambulance behind it"
    expected = "recover"
    suspends = frozenset({"blocked", "wrong_lane"})
    oncoming_gaps_m = PASSABLE_M
    starts = "the ambulance comes when the hero is stopped within 25 m of the car"
    needs_map = "one lane each way"
    blueprints = (AMBULANCE, CAR)

    def stage(self) -> None:
        self.put_disabled(CAR)

    def situation(self) -> Iterator[None]:
        self.traffic.switch_route_sources(False)
        yield from self.hero_near()
        yield from self.until(lambda: self.hero.speed_mps < STANDING_MPS)
        self.traffic.remove_behind()
        yield
        here = self.setting.route.waypoint_at(self.setting.hero_s_m)
        place = next((p for d in (BEHIND_M, 30.0, 20.0) if (p := back(here, d)) is not None), None)
        member = None if place is None else self.cast.spawn(AMBULANCE, place.transform)
        if member is not None:
            self.cast.lights(member, lamps("Special1", "Special2"))
            self.cars.drive(member, place, SPEED_MPS, obeys_lights=False)
