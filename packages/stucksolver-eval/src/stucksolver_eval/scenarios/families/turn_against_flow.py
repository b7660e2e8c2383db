"""Turns at a junction across or into a flow of traffic."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.junction import JunctionScenario, straight_way, way_to
from stucksolver_eval.scenarios.families.vehicle_flow import Flow
from stucksolver_eval.scenarios.parameters import NumberParameter, RangeParameter

if TYPE_CHECKING:
    import carla

RED_S = 5.0
"""Duration of the hero's red light (s)."""


class TurnAgainstFlow(JunctionScenario):
    """Base: a flow of cars at constant speed through the junction. If there are lights, the hero's is red at first."""

    flow_mps = NumberParameter("flow_speed", 10.0, "m/s")
    gaps_m = RangeParameter("source_dist_interval", (5.0, 7.0), "m")
    signalized: ClassVar[bool] = False
    source_s: ClassVar[float] = 4.0
    """Distance of the source before the junction, in seconds at the flow's speed."""
    sink_s: ClassVar[float] = 2.5
    """Distance of the flow's end after the junction, in seconds at the flow's speed."""
    comes_from: ClassVar[str] = "opposite"
    wanted_turn: ClassVar[str] = "left"
    prefilled: ClassVar[bool] = False

    def needs(self, setting: ScenarioContext) -> str | None:
        missing = super().needs(setting)
        if missing is not None:
            return missing
        if self.signalized and not self.own_lights:
            return "the hero has no traffic light at its next junction"
        if not self.flow_entries():
            return f"at the hero's next junction no traffic can come from the {self.comes_from} side"
        return None

    @abstractmethod
    def flow_entries(self) -> list[Any]:
        """Return the last waypoints before the junction on the flow's lanes."""

    def lane_rating(self, entry: carla.Waypoint) -> Any:
        """Return the rating of the flow's lanes through the junction; see `JunctionScenario.approach`."""
        return straight_way

    def script(self) -> Iterator[None]:
        starts = self.flow_entries()
        self.traffic.handle_junction_scenario(remove_entries=starts, remove_exits=[self.exit])
        self.traffic.change_opposite_behavior(active=False)
        flows = [self._flow(entry) for entry in starts]
        if self.prefilled:
            for flow in flows:
                flow.fill()
        lit = self.lights_of({entry.road_id for entry in starts}) if self.signalized else []
        if self.signalized:
            self.hold_lights(green=[item for item in lit if item not in self.own_lights])
        green_at_s = self.cast.time_s + RED_S
        while not (self.passes_exit() or self.at_route_end()):
            for flow in flows:
                flow.tick()
            if self.signalized and self.cast.time_s >= green_at_s:
                self.hold_lights(green=[*lit, *self.own_lights])
                green_at_s = float("inf")
            yield
        for flow in flows:
            flow.clear()
        self.free_lights()
        self.traffic.change_opposite_behavior(active=True)

    def _flow(self, entry: carla.Waypoint) -> Flow:
        speed = self.flow_mps
        line = self.approach(entry, self.source_s * speed, self.sink_s * speed, self.lane_rating(entry))
        return Flow(self, line, speed, self.gaps_m)


class LeftTurn(TurnAgainstFlow):
    """Base: oncoming cars go straight on."""

    needs_map = "a junction with an oncoming road"

    def flow_entries(self) -> list[Any]:
        return [entry for entry in self.entries_from("opposite") if self._can(entry, straight_way, 40.0)]

    def _can(self, entry: carla.Waypoint, rate: Any, most: float) -> bool:
        inside = [item for item in entry.next(2.0) if item.is_junction]
        return any(rate(entry, item) < most for item in inside)


class RightTurn(TurnAgainstFlow):
    """Base: cars from the left enter the road that the hero turns into."""

    needs_map = "a junction with a road from the left"
    source_s, sink_s = 5.0, 3.0
    comes_from = "left"
    prefilled = True

    def flow_entries(self) -> list[Any]:
        into = way_to(self.exit.road_id)
        return [entry for entry in self.entries_from("left") if _leads(entry, into)]

    def lane_rating(self, entry: carla.Waypoint) -> Any:
        return way_to(self.exit.road_id, self.exit.lane_id)


class LeftTurnEnterFlow(TurnAgainstFlow):
    """Base: oncoming cars turn right into the road that the hero turns left into."""

    needs_map = "a junction with an oncoming road"

    def flow_entries(self) -> list[Any]:
        into = way_to(self.exit.road_id)
        return [entry for entry in self.entries_from("opposite") if _leads(entry, into)]

    def lane_rating(self, entry: carla.Waypoint) -> Any:
        return way_to(self.exit.road_id, self.exit.lane_id)


def _leads(entry: carla.Waypoint, into: Any) -> bool:
    """Return True if a lane leads to the road of the rating `into` (see `way_to`)."""
    return any(into(entry, item) < 1000.0 for item in entry.next(2.0) if item.is_junction)
