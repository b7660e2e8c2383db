"""Background traffic: cars around the hero on its road, in the oncoming lanes, and at the junctions ahead.

The numbers are those of the CARLA leaderboard's background activity as Bench2Drive uses it. docs/scenarios.md lists the
simplifications.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stucksolver_eval.background_traffic.crossing import CrossingTraffic
from stucksolver_eval.background_traffic.ego_snapshot import EgoSnapshot
from stucksolver_eval.background_traffic.lanes import route_junctions
from stucksolver_eval.background_traffic.oncoming import OncomingTraffic
from stucksolver_eval.background_traffic.road import RoadTraffic

if TYPE_CHECKING:
    import carla

    from stucksolver_eval.scenario_context import ScenarioContext

EVERY = 5
"""Ticks between two updates of spawning, removal and speeds."""
_CLAIM_M = 8.0
"""Distance to a junction from which the hero's path is reserved (m). Ours."""
_CLAIM_MPS = 1.0
"""Speed of the hero from which its path is reserved (m/s). Ours."""


class Background:
    """All background traffic.

    Call `populate` once and `tick` after every tick. The other methods are hooks for scenarios.
    """

    def __init__(self, setting: ScenarioContext, empty: bool = False) -> None:
        """With `empty` there is no traffic, and the hooks have no effect."""
        self._setting, self._empty = setting, empty
        self._ego = EgoSnapshot(setting)
        self._junctions = route_junctions(setting.route)
        self._ticks = 0
        self.road = RoadTraffic(self._ego)
        self.oncoming = OncomingTraffic(self._ego)
        self.crossing = CrossingTraffic(self._ego)

    def populate(self) -> None:
        """Spawn the first cars around the hero."""
        if self._empty:
            return
        hero = self._setting.hero.get_location()
        index = self._setting.route.project(hero)
        self._look(float(self._setting.route.s_m[index]))
        self.road.populate()

    def tick(self, time_s: float, hero_s_m: float) -> None:
        """Spawn and remove cars, and set their speeds. `hero_s_m` is the hero's arc length on the route (m)."""
        self._ticks += 1
        if self._empty or self._ticks % EVERY:
            return
        self._look(hero_s_m)
        self._claim_for_hero()
        self.road.tick()
        self.oncoming.tick()
        self.crossing.tick()
        for car in self.crossing.hand_over():
            self.road.adopt(car)

    # Hooks for scenarios

    def leave_space_in_front(self, space_m: float) -> None:
        """Move the cars ahead forward, so that the nearest is at least `space_m` away."""
        self.road.leave_space(space_m)

    def remove_road_lane(self, waypoint: carla.Waypoint) -> None:
        """Keep the lane of this waypoint, on the hero's road, free of traffic until `readd_road_lane`."""
        self.road.close_lane(waypoint)

    def readd_road_lane(self, waypoint: carla.Waypoint) -> None:
        """Reopen a lane that `remove_road_lane` closed."""
        self.road.open_lane(waypoint)

    def set_max_speed(self, speed_mps: float | None) -> None:
        """Limit the speed of the traffic on the hero's road in both directions; None removes the limit."""
        self.road.cap_mps = self.oncoming.cap_mps = speed_mps

    def change_road_behavior(self, spawn_m: float | None = None, extra_space_m: float | None = None) -> None:
        """Set the spacing of new cars behind the hero, and the extra distance for cars ahead.

        None restores the default.
        """
        self.road.spacing_m = self.road.SPACING_M if spawn_m is None else spawn_m
        self.road.extra_space_m = 0.0 if extra_space_m is None else extra_space_m

    def change_opposite_behavior(self, active: bool = True, spawn_m: float | None = None) -> None:
        """Switch new oncoming traffic on or off (existing cars drive on), and set its spacing.

        None restores the default.
        """
        self.oncoming.active = active
        self.oncoming.spacing_m = self.oncoming.SPACING_M if spawn_m is None else spawn_m

    def clear_opposite(self) -> None:
        """Remove the oncoming cars."""
        self.oncoming.clear()

    def handle_junction_scenario(
        self,
        clear_middle: bool = True,
        clear_ego_entry: bool = True,
        remove_entries: Sequence[Any] = (),
        remove_exits: Sequence[Any] = (),
        stop_entries: bool = True,
        extend_exit_m: float = 0.0,
    ) -> None:
        """Clear the hero's next junction for a scenario's own traffic.

        Args:
            clear_middle: Remove cars inside the junction.
            clear_ego_entry: Remove cars ahead of the hero.
            remove_entries: Waypoints of entry roads to clear.
            remove_exits: Waypoints of exit roads to clear.
            stop_entries: Spawn no new cars on the other entries.
            extend_exit_m: Length of the hero's exit to keep free (m).
        """
        self.crossing.quiet(clear_middle, {w.road_id for w in (*remove_entries, *remove_exits)}, stop_entries)
        if clear_ego_entry:
            self.road.remove_ahead()
        if extend_exit_m:
            self.crossing.exit_gap_m = extend_exit_m

    def switch_route_sources(self, enabled: bool) -> None:
        """Switch the spawning of cars behind the hero on or off."""
        self.road.sources = enabled

    def stop_front(self) -> None:
        """Make the cars ahead brake hard and stop."""
        self.road.front_stopped = True

    def start_front(self) -> None:
        """Let the cars ahead drive again."""
        self.road.front_stopped = False

    def stop_back(self) -> None:
        """Make the cars behind stop."""
        self.road.back_stopped = True

    def start_back(self) -> None:
        """Let the cars behind drive again."""
        self.road.back_stopped = False

    def remove_behind(self) -> None:
        """Remove the cars behind the hero in its own lane."""
        self.road.remove_behind()

    def leave_crossing_space(self, x: float, y: float) -> None:
        """Remove oncoming cars within 20 m of a crossing, and stop those that approach it within 30 m."""
        self.oncoming.keep_off(x, y)

    def _look(self, hero_s_m: float) -> None:
        ego, setting = self._ego, self._setting
        ego.index, ego.s_m = setting.route.index_at(hero_s_m), hero_s_m
        ego.speed_mps = setting.cast.hero.speed_mps
        ego.limit_mps = max(setting.hero.get_speed_limit(), 10.0) / 3.6
        ego.junction = next((junction for junction in self._junctions if junction.last >= ego.index), None)
        ego.junction_in_m = math.inf
        if ego.junction is not None:
            ego.junction_in_m = max(float(setting.route.s_m[ego.junction.first]) - hero_s_m, 0.0)

    def _claim_for_hero(self) -> None:
        """Reserve the hero's path through a junction that it is about to enter, so that the other cars yield."""
        ego, claims = self._ego, self._setting.cars.claims
        junction = ego.junction
        coming = ego.junction_in_m < _CLAIM_M and ego.speed_mps > _CLAIM_MPS
        if junction is None or not (ego.junction_in_m == 0.0 or coming):
            claims.hero(None, None)
            return
        claims.hero(junction.number, self._setting.route.xyz[max(ego.index - 2, 0) : junction.last + 1, :2])
