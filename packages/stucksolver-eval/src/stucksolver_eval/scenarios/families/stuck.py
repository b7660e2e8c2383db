"""Base classes of the additional immobilizing situations.

Each type states the right action and the criteria it suspends.

Their numbers are ours.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

from stucksolver_eval.actors import ScenarioActor
from stucksolver_eval.actors.actor_pool import HAZARD_LAMPS, lamps
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.crossing_actors import WALKER_LIFT_M
from stucksolver_eval.scenarios.families.junction import JunctionScenario
from stucksolver_eval.scenarios.families.lane_places import offset_pose
from stucksolver_eval.scenarios.families.obstacle import oncoming_flow
from stucksolver_eval.scenarios.parameters import NumberParameter
from stucksolver_eval.scenarios.scenario import Scenario

PASSABLE_M = (180.0, 360.0)
"""Range of distances between oncoming cars (m). It includes gaps long enough for a pass."""
FAR_M = 160.0
"""Distance at which oncoming cars start (m). It exceeds the sight distance for a pass."""
NEAR_M, QUEUE_M, STANDING_MPS = 25.0, 60.0, 0.1
"""Distances at which the hero has arrived (m), also in the queue before a light, and its speed when stopped (m/s).

The hero has arrived within `NEAR_M`, or when stopped within `QUEUE_M` of a light.
"""
PAST_M = 25.0
"""Distance beyond the situation at which the hero has passed it (m)."""


class StuckScenario(Scenario):
    """Base: a situation `distance` beyond the trigger. It ends when the hero has passed it."""

    timeout_s = None
    starts = "present from the start"
    distance_m = NumberParameter("distance", 42.0, "m")
    oncoming_gaps_m: ClassVar[tuple[float, float] | None] = None
    """Range of distances between oncoming cars if the path past is their lane (m).

    With None the background controls them.
    """

    def script(self) -> Iterator[None]:
        self.traffic.leave_space_in_front(self.distance_m + 40.0)
        if self.oncoming_gaps_m is None:
            yield from self._until_past()
        else:
            yield from self._with_oncoming(self.oncoming_gaps_m)

    def _until_past(self) -> Iterator[None]:
        yield from self.situation()
        yield from self.until_passed(self.trigger_s_m + self.distance_m + PAST_M)

    def _with_oncoming(self, gaps_m: tuple[float, float]) -> Iterator[None]:
        self.traffic.change_opposite_behavior(active=False)
        flow = oncoming_flow(self, self.distance_m, gaps_m, least_reach_m=FAR_M)
        for _ in self._until_past():
            flow.tick()
            yield
        flow.clear()
        self.traffic.change_opposite_behavior(active=True)

    def situation(self) -> Iterator[None]:
        """Script: the events from the trigger until the road is free again, if it ever is."""
        yield

    def hero_near(self) -> Iterator[None]:
        """Script: wait until the hero has arrived."""
        place_s = self.s_at(self.distance_m)
        yield from self.until(lambda: self.gap_m(place_s) < NEAR_M)

    def spawn_at(
        self, blueprint: str, ahead_m: float = 0.0, right_m: float = 0.0, turn_deg: float = 0.0, **options: Any
    ) -> ScenarioActor:
        """Spawn an actor `ahead_m` beyond `distance` and `right_m` from the lane's center. Vehicles are parked."""
        place = offset_pose(self.ahead(self.distance_m + ahead_m), right_m, turn_deg=turn_deg)
        lift_m = WALKER_LIFT_M if blueprint.startswith("walker.") else 0.0 if "static." in blueprint else 0.3
        member = self.cast.must_spawn(blueprint, place, lift_m=lift_m, **options)
        if blueprint.startswith("vehicle."):
            self.cast.hold(member)
        return member

    def put_disabled(self, blueprint: str, ahead_m: float = 0.0, right_m: float = 0.0) -> ScenarioActor:
        """Spawn a stopped vehicle with its hazard lights on."""
        member = self.spawn_at(blueprint, ahead_m, right_m)
        self.cast.lights(member, lamps(*HAZARD_LAMPS))
        return member


class StuckAtLight(JunctionScenario):
    """Base: a situation at the hero's next junction, whose lights the scenario controls."""

    timeout_s = None
    starts = "from the trigger on"
    needs_map = "a junction on the route whose lights stop the hero"
    lasts_s: ClassVar[float] = 30.0
    """Duration of the situation (s)."""

    def needs(self, setting: ScenarioContext) -> str | None:
        missing = super().needs(setting)
        if missing is None and not self.own_lights:
            missing = "the hero has no traffic light at its next junction"
        return missing

    def script(self) -> Iterator[None]:
        yield from self.situation()
        yield from self.until_passed(self.exit_s + 10.0)
        self.free_lights()

    def situation(self) -> Iterator[None]:
        """Script: control the lights."""
        yield

    def hero_near(self) -> Iterator[None]:
        """Script: wait until the hero has reached the junction, or is stopped in the queue before it."""

        def near() -> bool:
            return self.gap_m(self.entry_s) < (QUEUE_M if self.hero.speed_mps < STANDING_MPS else NEAR_M)

        yield from self.until(near)
