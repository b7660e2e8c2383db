"""Something stands in the hero's lane: what all obstacle scenarios share, and how the hero may get past."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar

import carla

from stucksolver_eval.actors import Car, ScenarioActor
from stucksolver_eval.actors.pool import HAZARD_LAMPS, lamps
from stucksolver_eval.background.lanes import oncoming_lanes
from stucksolver_eval.scenarios.actions.flow import Flow
from stucksolver_eval.scenarios.actions.places import beside, run_of_lane, side_driving_lane, upstream
from stucksolver_eval.scenarios.base import Scenario
from stucksolver_eval.scenarios.parameters import Choice, Number, Range
from stucksolver_eval.setting import Setting

PAST_M = 50.0
ROOM_BEYOND_M = 20.0


class Obstacle(Scenario):
    """Base: `put` places it; the way past is the lane beside, where traffic goes on at no more than `speed`."""

    needs_map = "a second driving lane beside the hero's"
    distance_m = Number("distance", 120.0, "m")
    direction = Choice("direction", "right", options=("left", "right"))
    speed_kmh = Number("speed", 60.0, "km/h")
    watch_m: ClassVar[float] = 50.0
    """Side traffic changes once the hero is so near, and `settle_s` later."""
    settle_s: ClassVar[float] = 5.0
    _first_m = 0.0
    _last_m = 0.0

    def needs(self, setting: Setting) -> str | None:
        side = "left" if self.direction == "right" else "right"
        if side_driving_lane(self.ahead(self.distance_m), side) is None:
            return f"{self.distance_m:.0f} m beyond the trigger point there is no driving lane on the {side}"
        return None

    @abstractmethod
    def put(self) -> tuple[float, float]:
        """Place the obstacle; where it begins and ends, in metres beyond the trigger."""

    def stage(self) -> None:
        self._first_m, self._last_m = self.put()

    def script(self) -> Iterator[None]:
        self.clear_lane()
        first_s, last_s = self.trigger_s_m + self._first_m, self.trigger_s_m + self._last_m
        yield from self.until(lambda: self.gap_m(first_s) < self.watch_m)
        yield from self.wait(self.settle_s)
        yield from self.way_past(last_s + PAST_M)

    def clear_lane(self) -> None:
        """Nobody between the hero and the obstacle."""
        self.traffic.leave_space_in_front(self._last_m + ROOM_BEYOND_M)

    def way_past(self, end_s: float) -> Iterator[None]:
        """Until the hero is past."""
        self.traffic.set_max_speed(self.speed_kmh / 3.6)
        yield from self.until_passed(end_s)
        self.traffic.set_max_speed(None)

    # What subclasses place.

    @property
    def sign(self) -> float:
        """+1 where right is the side of the obstacle."""
        return 1.0 if self.direction == "right" else -1.0

    def park(self, blueprint: str, distance_m: float, offset: float, **options: Any) -> ScenarioActor:
        """A vehicle with the hand brake on, off the lane's middle by a share of half its width."""
        waypoint = self.ahead(distance_m)
        shift_m = self.sign * offset * waypoint.lane_width / 2.0
        member = self.cast.must_spawn(blueprint, beside(waypoint, shift_m), **options)
        self.cast.hold(member)
        return member

    def prop(self, blueprint: str, distance_m: float, right_m: float, turn_deg: float = 0.0) -> ScenarioActor:
        """A prop so far to the obstacle's side of the lane's middle."""
        place = beside(self.ahead(distance_m), self.sign * right_m, turn_deg=turn_deg)
        return self.cast.must_spawn(blueprint, place, lift_m=0.0, role="scenario")

    def new_car(self) -> str:
        """A car of CARLA's second generation, as the public scenarios use them."""
        return self.random.choice(self.new_cars())

    def new_cars(self) -> list[str]:
        """Ordinary cars of CARLA's second generation, whose lamps can be lit."""
        ordinary = set(self.cast.car_kinds)
        return [one for one in self.cast.kinds(base_type="car", generation="2") if one in ordinary]

    def hazard_lamps(self, member: ScenarioActor) -> None:
        """Lights the hazard lamps of an actor."""
        self.cast.lights(member, lamps(*HAZARD_LAMPS))


class TwoWays(Obstacle):
    """The way past is the oncoming lane, in gaps of a flow that the scenario drives."""

    needs_map = "an oncoming lane beside the hero's"
    gaps_m = Range("frequency", (20.0, 100.0), "m")
    simplified = "the oncoming cars brake for what is ahead of them by the Intelligent Driver Model"

    def needs(self, setting: Setting) -> str | None:
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
        """The flow goes on until the hero has passed a place of the route."""
        for _ in self.until_passed(end_s):
            flow.tick()
            yield

    def oncoming_flow(
        self, offset_m: float = 0.0, gaps_m: tuple[float, float] | None = None, constant: bool = False
    ) -> Flow:
        """See `oncoming_flow` below; `gaps_m` where they are not the route file's."""
        return oncoming_flow(self, self.distance_m, gaps_m or self.gaps_m, offset_m, constant)


def oncoming_flow(
    scenario: Scenario,
    distance_m: float,
    gaps_m: tuple[float, float],
    offset_m: float = 0.0,
    constant: bool = False,
    least_reach_m: float = 0.0,
) -> Flow:
    """Cars in the oncoming lane at the hero's speed limit, from far beyond a place to far behind it.

    The place is `distance_m` beyond the trigger, where there must be an oncoming lane. How far is the public
    benchmark's rule, but `least_reach_m` at least.
    """
    limit = scenario.limit_mps
    reach_m = max(1.5 * 3.6 * limit + 30.0, least_reach_m)
    lane = oncoming_lanes(scenario.ahead(distance_m))[0]
    line = run_of_lane(upstream(lane, reach_m), 2.0 * reach_m)
    return Flow(scenario, line, limit, gaps_m, constant=constant, offset_m=offset_m)


class ConstructionSite(Obstacle):
    """A trailer with a sign, debris and cones, which rise from below the ground at the trigger."""

    blueprints = (
        "static.prop.trafficwarning",
        "static.prop.dirtdebris02",
        "static.prop.constructioncone",
        "static.prop.warningconstruction",
    )
    watch_m = 30.0
    _CONES = ((-9.0, 1.0), (-6.0, 0.35), (-3.0, -0.3), (0.0, -0.95))
    _LENGTH_M = 12.0

    def put(self) -> tuple[float, float]:
        """Everything waits below the ground; see `raise_site`."""
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
        """Cars ahead go beyond the site, and nobody new comes into the lane."""
        super().clear_lane()
        self.traffic.remove_road_lane(self.ahead(self.distance_m))
        for member, place in self._parts:
            self.cast.bring(member, place, lift_m=0.0)

    def way_past(self, end_s: float) -> Iterator[None]:
        yield from super().way_past(end_s)
        self.traffic.readd_road_lane(self.ahead(self.distance_m))

    def _keep(self, blueprint: str, along_m: float, right_m: float, turn_deg: float) -> None:
        place = beside(self.ahead(self.distance_m + along_m), self.sign * right_m, turn_deg=turn_deg)
        self._parts.append((self.cast.keep_below(blueprint), place))


class SlowBicycles(Obstacle):
    """Two bicycles at the edge of the lane, 9 m apart, that ride slowly and then stand."""

    simplified = "the bicycles hold their speed whatever comes"

    needs_map = "a second driving lane beside the hero's"
    distance_m = Number("distance", 100.0, "m")
    bicycle_kmh = Number("bicycle_speed", 10.0, "km/h")
    ride_m = Number("bicycle_drive_distance", 50.0, "m")
    blueprints = ("vehicle.bh.crossbike", "vehicle.diamondback.century")
    _APART_M = 9.0
    _OFFSET = 0.55

    def put(self) -> tuple[float, float]:
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
        """Whether the hero is 50 m past the one in front, or at the end of its route."""
        route, state = self.setting.route, self.cast.state(rider.member)
        near = route.index_at(self.setting.hero_s_m)
        rider_s = float(route.s_m[route.project(carla.Location(state.x, state.y, state.z), near)])
        return self.setting.hero_s_m >= min(rider_s + PAST_M, route.length_m - 3.0)

    def begin_way_past(self) -> None:
        """Slows the traffic beside them."""
        self.traffic.set_max_speed(self.speed_kmh / 3.6)

    def end_way_past(self) -> None:
        """Lets the traffic go at its own speed."""
        self.traffic.set_max_speed(None)

    def _ride(self) -> list[Car]:
        found = []
        for k, member in enumerate(self._bicycles):
            waypoint = self.ahead(self.distance_m + k * self._APART_M)
            shift_m = self.sign * self._OFFSET * waypoint.lane_width / 2.0
            found.append(self.cars.drive(member, waypoint, self.bicycle_kmh / 3.6, offset_m=shift_m, constant=True))
        return found
