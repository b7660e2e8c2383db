"""Obstacles in the hero's lane: base classes of all obstacle scenarios, and the path past them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar

import carla

from stucksolver_eval.actors import Car, ScenarioActor
from stucksolver_eval.actors.actor_pool import HAZARD_LAMPS, lamps
from stucksolver_eval.background_traffic.lanes import oncoming_lanes
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.lane_places import offset_pose, run_of_lane, side_driving_lane, upstream
from stucksolver_eval.scenarios.families.vehicle_flow import Flow
from stucksolver_eval.scenarios.parameters import ChoiceParameter, NumberParameter, RangeParameter
from stucksolver_eval.scenarios.scenario import Scenario

PAST_M = 50.0
"""Distance beyond the obstacle at which the hero has passed it (m). As in scenario_runner."""
ROOM_BEYOND_M = 20.0
"""Length of road without cars beyond the obstacle (m). Ours."""


class Obstacle(Scenario):
    """Base: the path past the obstacle is the adjacent lane, with traffic at `speed` at most."""

    needs_map = "a second driving lane next to the hero's"
    distance_m = NumberParameter("distance", 120.0, "m")
    direction = ChoiceParameter("direction", "right", options=("left", "right"))
    speed_kmh = NumberParameter("speed", 60.0, "km/h")
    watch_m: ClassVar[float] = 50.0
    """Distance of the hero at which traffic in the adjacent lane changes, after `settle_s` (m)."""
    settle_s: ClassVar[float] = 5.0
    """Time from then to the change (s)."""
    _first_m = 0.0
    _last_m = 0.0

    def needs(self, setting: ScenarioContext) -> str | None:
        side = "left" if self.direction == "right" else "right"
        if side_driving_lane(self.ahead(self.distance_m), side) is None:
            return f"{self.distance_m:.0f} m beyond the trigger point there is no driving lane on the {side}"
        return None

    @abstractmethod
    def place_obstacle(self) -> tuple[float, float]:
        """Place the obstacle. Returns its start and its end (m beyond the trigger)."""

    def stage(self) -> None:
        self._first_m, self._last_m = self.place_obstacle()

    def script(self) -> Iterator[None]:
        self.clear_lane()
        first_s, last_s = self.trigger_s_m + self._first_m, self.trigger_s_m + self._last_m
        yield from self.until(lambda: self.gap_m(first_s) < self.watch_m)
        yield from self.wait(self.settle_s)
        yield from self.way_past(last_s + PAST_M)

    def clear_lane(self) -> None:
        """Remove traffic between the hero and the obstacle."""
        self.traffic.leave_space_in_front(self._last_m + ROOM_BEYOND_M)

    def way_past(self, end_s: float) -> Iterator[None]:
        """Script: control the traffic until the hero has passed arc length `end_s` (m)."""
        self.traffic.set_max_speed(self.speed_kmh / 3.6)
        yield from self.until_passed(end_s)
        self.traffic.set_max_speed(None)

    # ---- placing objects in subclasses

    @property
    def sign(self) -> float:
        """+1 if the obstacle is on the right, -1 if on the left."""
        return 1.0 if self.direction == "right" else -1.0

    def park(self, blueprint: str, distance_m: float, offset: float, **options: Any) -> ScenarioActor:
        """Spawn a vehicle with the hand brake on. `offset` from the lane's center is a share of half the lane width."""
        waypoint = self.ahead(distance_m)
        shift_m = self.sign * offset * waypoint.lane_width / 2.0
        member = self.cast.must_spawn(blueprint, offset_pose(waypoint, shift_m), **options)
        self.cast.hold(member)
        return member

    def prop(self, blueprint: str, distance_m: float, right_m: float, turn_deg: float = 0.0) -> ScenarioActor:
        """Spawn a prop `right_m` from the lane's center toward the obstacle's side."""
        place = offset_pose(self.ahead(distance_m), self.sign * right_m, turn_deg=turn_deg)
        return self.cast.must_spawn(blueprint, place, lift_m=0.0, role="scenario")

    def new_car(self) -> str:
        """Return a random one of `new_cars`, which the public scenarios use."""
        return self.random.choice(self.new_cars())

    def new_cars(self) -> list[str]:
        """Return the ordinary cars of CARLA's second generation, which have working lamps."""
        ordinary = set(self.cast.car_kinds)
        return [kind for kind in self.cast.kinds(base_type="car", generation="2") if kind in ordinary]

    def hazard_lamps(self, member: ScenarioActor) -> None:
        """Switch on the hazard lights of an actor."""
        self.cast.lights(member, lamps(*HAZARD_LAMPS))


class TwoWayObstacle(Obstacle):
    """Base: the path past the obstacle is the oncoming lane, in gaps of a flow that the scenario controls."""

    needs_map = "an oncoming lane next to the hero's"
    gaps_m = RangeParameter("frequency", (20.0, 100.0), "m")
    simplified = "the oncoming cars follow the vehicle ahead by the Intelligent Driver Model"

    def needs(self, setting: ScenarioContext) -> str | None:
        if not oncoming_lanes(self.ahead(self.distance_m)):
            return f"{self.distance_m:.0f} m beyond the trigger point there is no adjacent oncoming lane"
        return None

    def way_past(self, end_s: float) -> Iterator[None]:
        self.suspended.add("wrong_lane")
        self.traffic.change_opposite_behavior(active=False)
        flow = self.oncoming_flow()
        yield from self.along(flow, end_s)
        flow.clear()
        self.suspended.discard("wrong_lane")
        self.traffic.change_opposite_behavior(active=True)

    def along(self, flow: Flow, end_s: float) -> Iterator[None]:
        """Script: run the flow until the hero has passed arc length `end_s` (m)."""
        for _ in self.until_passed(end_s):
            flow.tick()
            yield

    def oncoming_flow(
        self, offset_m: float = 0.0, gaps_m: tuple[float, float] | None = None, constant: bool = False
    ) -> Flow:
        """Create an oncoming flow; see `oncoming_flow`. `gaps_m` defaults to the route file's."""
        return oncoming_flow(self, self.distance_m, gaps_m or self.gaps_m, offset_m, constant)


def oncoming_flow(
    scenario: Scenario,
    distance_m: float,
    gaps_m: tuple[float, float],
    offset_m: float = 0.0,
    constant: bool = False,
    least_reach_m: float = 0.0,
) -> Flow:
    """Create a flow in the oncoming lane at the hero's speed limit, around a position `distance_m` beyond the trigger.

    There must be an oncoming lane at the position. The flow starts and ends at the distance of the public benchmark,
    but at least at `least_reach_m`.
    """
    limit = scenario.limit_mps
    reach_m = max(1.5 * 3.6 * limit + 30.0, least_reach_m)
    lane = oncoming_lanes(scenario.ahead(distance_m))[0]
    line = run_of_lane(upstream(lane, reach_m), 2.0 * reach_m)
    return Flow(scenario, line, limit, gaps_m, constant=constant, offset_m=offset_m)


class ConstructionSite(Obstacle):
    """Base: a trailer with a sign, debris and cones, which appear at the trigger."""

    blueprints = (
        "static.prop.trafficwarning",
        "static.prop.dirtdebris02",
        "static.prop.constructioncone",
        "static.prop.warningconstruction",
    )
    watch_m = 30.0
    _CONES = ((-9.0, 1.0), (-6.0, 0.35), (-3.0, -0.3), (0.0, -0.95))
    _LENGTH_M = 12.0

    def place_obstacle(self) -> tuple[float, float]:
        """Stage all parts below the ground. `clear_lane` brings them up."""
        self.prop("static.prop.warningconstruction", 0.0, self.ahead(0.0).lane_width / 2.0 + 0.8, turn_deg=180.0)
        self._parts: list[tuple[ScenarioActor, Any]] = []
        half_m = self.ahead(self.distance_m).lane_width / 2.0
        self._keep("static.prop.trafficwarning", 0.0, 0.0, 0.0)
        self._keep("static.prop.dirtdebris02", 5.0, 0.2, 0.0)
        for along_m, share in self._CONES:
            self._keep("static.prop.constructioncone", along_m, share * half_m, 0.0)
        for k in range(5):
            self._keep("static.prop.constructioncone", 2.0 + 2.5 * k, -0.95 * half_m, 0.0)
        for k in range(2):
            self._keep("static.prop.constructioncone", self._LENGTH_M, (0.95 * k - 0.3) * half_m, 0.0)
        return self.distance_m - 9.0, self.distance_m + self._LENGTH_M

    def clear_lane(self) -> None:
        """Move cars ahead beyond the site, close the lane to new ones, and bring up the site."""
        super().clear_lane()
        self.traffic.remove_road_lane(self.ahead(self.distance_m))
        for member, place in self._parts:
            self.cast.bring(member, place, lift_m=0.0)

    def way_past(self, end_s: float) -> Iterator[None]:
        yield from super().way_past(end_s)
        self.traffic.readd_road_lane(self.ahead(self.distance_m))

    def _keep(self, blueprint: str, along_m: float, right_m: float, turn_deg: float) -> None:
        place = offset_pose(self.ahead(self.distance_m + along_m), self.sign * right_m, turn_deg=turn_deg)
        self._parts.append((self.cast.keep_below(blueprint), place))


class SlowBicycles(Obstacle):
    """Base: two bicycles at the edge of the lane, 9 m apart, that ride slowly and then stop."""

    simplified = "the bicycles hold their speed in spite of objects in their path"

    needs_map = "a second driving lane next to the hero's"
    distance_m = NumberParameter("distance", 100.0, "m")
    bicycle_kmh = NumberParameter("bicycle_speed", 10.0, "km/h")
    ride_m = NumberParameter("bicycle_drive_distance", 50.0, "m")
    blueprints = ("vehicle.bh.crossbike", "vehicle.diamondback.century")
    _APART_M = 9.0
    _OFFSET = 0.55

    def place_obstacle(self) -> tuple[float, float]:
        self._bicycles = [
            self.park(self.blueprints[k % 2], self.distance_m + k * self._APART_M, self._OFFSET) for k in range(2)
        ]
        return self.distance_m, self.distance_m + self._APART_M

    def script(self) -> Iterator[None]:
        self.clear_lane()
        riders = self._ride()
        self.begin_way_past()
        while not self._is_past(riders[-1]):
            for rider in riders:
                if rider.s >= self.ride_m:
                    self.cars.relax(rider)
                    rider.wish_mps = 0.0
            yield
        self.end_way_past()

    def _is_past(self, rider: Car) -> bool:
        """Return True if the hero is 50 m beyond a rider, or at the end of its route."""
        route, state = self.setting.route, self.cast.state(rider.member)
        near = route.index_at(self.setting.hero_s_m)
        rider_s = float(route.s_m[route.project(carla.Location(state.x, state.y, state.z), near)])
        return self.setting.hero_s_m >= min(rider_s + PAST_M, route.length_m - 3.0)

    def begin_way_past(self) -> None:
        """Slow down the traffic in the adjacent lane."""
        self.traffic.set_max_speed(self.speed_kmh / 3.6)

    def end_way_past(self) -> None:
        """Remove the limit on the traffic's speed."""
        self.traffic.set_max_speed(None)

    def _ride(self) -> list[Car]:
        found = []
        for k, member in enumerate(self._bicycles):
            waypoint = self.ahead(self.distance_m + k * self._APART_M)
            shift_m = self.sign * self._OFFSET * waypoint.lane_width / 2.0
            found.append(self.cars.drive(member, waypoint, self.bicycle_kmh / 3.6, offset_m=shift_m, constant=True))
        return found
