"""Scatters all kinds of objects that a detector must find along a route; kinds that are rare in traffic are frequent.

It places vehicles of all blueprints, stopped or driving, with random lamps and doors, pedestrians, animals, and objects
on lanes, shoulders and sidewalks. They belong to the run's actor pool, which destroys them at the end.

Half of the crowds block the lanes, so that all vehicles are soon stopped. In the other half the lanes are free, and
vehicles of all kinds drive in them, also from behind and toward the ego.

The numbers are ours.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random
from typing import Any

import carla

from lab.perception.recording import pedestrian_groups
from lab.perception.recording.scattered_kinds import (
    LOW,
    LOW_SHARES,
    ON_FEET,
    ON_WHEELS,
    REACH_OF_M,
    SHARES,
    Shares,
    blueprints_by_kind,
    deal,
)
from stucksolver.scene import ObjectKind
from stucksolver.scene.objects import Gesture
from stucksolver_eval.actors.actor_pool import LIFT_M, ScenarioActor, lamps
from stucksolver_eval.actors.cars import Car
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.crossing_actors import WALKER_LIFT_M

FIRST_M = 12.0
"""Arc length of the route at which the crowd starts (m)."""
REACH_M = 350.0
"""Arc length of the route at which the crowd ends (m): half a minute's drive, and as far as the sensors reach."""
BESIDE_PER_M = 0.28
"""Number of objects per meter of route beside the ego's lane."""
IN_LANE_PER_M = 0.015
"""Number of objects per meter of route in the ego's lane."""
LOW_PER_M = 0.06
"""Number of low objects per meter of route on the road."""
HELD_UP_MPS = 0.7
"""Speed below which the ego counts as blocked (m/s)."""
HELD_UP_S = 2.5
"""Time after which the objects that block the ego are removed (s), so that it reaches other objects."""
CLEARED_M = 25.0
"""Length ahead of the ego in which they are removed (m)."""
CLEARED_WIDE_M = 2.5
"""Width to each side of its heading in which they are removed (m)."""
DRIVERS_EVERY_M = 25.0
"""Average distance between driving vehicles in a crowd that blocks the lanes (m)."""
FLOWING_EVERY_M = 14.0
"""Average distance between driving vehicles in a crowd with free lanes (m)."""
BEHIND_M = 110.0
"""Distance behind the ego from which vehicles start in a crowd with free lanes (m)."""
DOOR_ODDS = 0.5
"""Probability that a stopped vehicle with movable doors has one open."""
WALK_MPS = (0.0, 0.0, 0.6, 1.2, 1.8, 2.6)
"""Walking speeds (m/s)."""
WISH_MPS = (3.0, 5.0, 8.0, 11.0, 14.0, 18.0)
"""Target speeds of driving vehicles (m/s)."""
TURN_EVERY_S = 4.0
"""Average interval at which walkers change direction and lamps change state (s)."""
CYCLE_S = (4.0, 14.0)
"""Range of the time for which a traffic light keeps its state (s)."""
_TRIES = 12
"""Number of tries to place an object."""
_ABOVE_M = 2.0
"""Height above a position from which the ground is searched (m); lower than any bridge."""
_LIFTS_M = (("static.", 0.0), ("walker.", WALKER_LIFT_M), ("animal.", WALKER_LIFT_M))
"""Spawn heights by blueprint prefix (m): props do not fall, and the origin of walkers is at their center."""
_APART_M = 0.5
"""Least gap between two objects (m)."""
_SMALL_REACH_M = 0.8
"""Radius of an object up to which it counts as small (m)."""
_LAMPS: tuple[tuple[str, ...], ...] = (
    (),
    ("Brake",),
    ("LeftBlinker",),
    ("RightBlinker",),
    ("LeftBlinker", "RightBlinker"),
    ("Position", "LowBeam"),
    ("Position", "LowBeam", "Brake"),
    ("Reverse",),
    ("Position", "Fog"),
)
_SIREN = ("Special1",)
GESTURES = tuple(gesture.value for gesture in Gesture)
"""Each flagger keeps one of these for the whole drive."""
_DOORS = ("FL", "FR", "RL", "RR")
SIGNALS = (
    carla.TrafficLightState.Red,
    carla.TrafficLightState.Yellow,
    carla.TrafficLightState.Green,
    carla.TrafficLightState.Off,
)


@dataclass
class _Lamped:
    member: ScenarioActor
    next_s: float = 0.0
    """Time of the next change (s)."""


@dataclass
class _Walkers:
    """One walker, or several that walk together."""

    members: list[ScenarioActor]
    next_s: float = 0.0
    """Time of the next change (s)."""


@dataclass
class _Signal:
    light: Any
    next_s: float = 0.0
    """Time of the next change (s)."""


class ScatteredObjects:
    """Create it when the ego is at the start; call `tick` on every tick. The same seed gives the same crowd."""

    def __init__(self, setting: ScenarioContext, seed: int) -> None:
        self._setting, self._cast = setting, setting.cast
        self._random = Random(f"{seed}:crowd")
        self._flows = Random(f"{seed}:{setting.route.length_m:.1f}:flows").random() < 0.5
        # Gestures have their own random numbers: the rest of a crowd stays the same as before flaggers signaled.
        self._gestures = Random(f"{seed}:gestures")
        self._kinds = blueprints_by_kind(setting.world.get_blueprint_library())
        self._end_m = min(setting.route.length_m, REACH_M)
        self._taken: list[tuple[float, float, float]] = []
        self._walkers: list[_Walkers] = []
        self._lamped: list[_Lamped] = []
        self._cars: dict[int, Car] = {}
        self._held_up_since_s: float | None = None
        lights = setting.world.get_actors().filter("traffic.traffic_light*")
        self._signals = [_Signal(light) for light in lights]
        setting.cast.take_snapshot()
        for signal in self._signals:
            signal.light.freeze(True)
        hero = setting.hero.get_location()
        self._taken.append((hero.x, hero.y, 6.0))
        self._scatter()
        self._spawn_traffic()
        setting.cast.flush()

    def tick(self, time_s: float) -> None:
        """Update walkers, lamps and traffic lights; commands are sent with the pool's next batch."""
        for walkers in self._walkers:
            if time_s >= walkers.next_s:
                walkers.next_s = time_s + self._random.uniform(0.5, 2.0) * TURN_EVERY_S
                self._stroll(walkers.members)
        for vehicle in self._lamped:
            if time_s >= vehicle.next_s:
                vehicle.next_s = time_s + self._random.uniform(0.5, 2.0) * TURN_EVERY_S
                self._light_up(vehicle.member)
        for signal in self._signals:
            if time_s >= signal.next_s:
                signal.next_s = time_s + self._random.uniform(*CYCLE_S)
                signal.light.set_state(self._random.choice(SIGNALS))
        self._unblock_hero(time_s)

    def _unblock_hero(self, time_s: float) -> None:
        """Remove the objects that block the ego, and set its traffic light to green."""
        hero = self._cast.hero
        if abs(hero.speed_mps) > HELD_UP_MPS:
            self._held_up_since_s = None
            return
        if self._held_up_since_s is None:
            self._held_up_since_s = time_s
        if time_s - self._held_up_since_s < HELD_UP_S:
            return
        self._held_up_since_s = time_s
        cos, sin = math.cos(hero.yaw_rad), math.sin(hero.yaw_rad)
        for member in list(self._cast.members.values()):
            at = self._cast.state(member)
            aside_m = abs((at.y - hero.y) * cos - (at.x - hero.x) * sin)
            reach_m = CLEARED_WIDE_M + member.half_width_m
            if 0.0 < hero.ahead_m(at.x, at.y) < CLEARED_M and aside_m < reach_m:
                self._remove(member)
        for signal in self._signals:
            near = self._setting.hero.get_traffic_light()
            if near is not None and near.id == signal.light.id:
                signal.light.set_state(carla.TrafficLightState.Green)
                signal.next_s = time_s + CYCLE_S[1]

    def _remove(self, member: ScenarioActor) -> None:
        for walkers in self._walkers:
            walkers.members = [actor for actor in walkers.members if actor is not member]
        self._walkers = [walkers for walkers in self._walkers if walkers.members]
        self._lamped = [item for item in self._lamped if item.member is not member]
        car = self._cars.pop(member.id, None)
        if car is None:
            self._cast.remove([member])
        else:
            self._setting.cars.remove([car])

    def _scatter(self) -> None:
        """Place all standing and walking objects at random along the route."""
        along_m = max(self._end_m - FIRST_M, 0.0)
        together = [self._gather() for _ in range(round(along_m / pedestrian_groups.EVERY_M))]
        for kind in self._deck(SHARES, round(along_m * BESIDE_PER_M)):
            self._put(
                kind, lambda here: self._random.choice((-1, 1)) * self._random.uniform(0.9, 3.2) * here.lane_width
            )
        if not self._flows:
            for kind in self._deck(SHARES, round(along_m * IN_LANE_PER_M)):
                self._put(kind, lambda here: self._random.uniform(-0.6, 0.6) * here.lane_width)
        for kind in self._deck(LOW_SHARES, round(along_m * LOW_PER_M)):
            self._put(kind, lambda here: self._random.uniform(-1.2, 1.2) * here.lane_width)
        self._walkers += [walkers for walkers in together if walkers is not None]

    def _deck(self, shares: Shares, count: int) -> list[ObjectKind]:
        return deal([(kind, share) for kind, share in shares if self._kinds.get(kind)], count, self._random)

    def _put(self, kind: ObjectKind, right_m: Callable[[carla.Waypoint], float]) -> None:
        """Spawn one object of a kind at a free position; stop after some tries.

        `right_m` draws the offset to the right of a lane's center (m).
        """
        name = self._random.choice(self._kinds[kind])
        reach_m = REACH_OF_M.get(kind, _SMALL_REACH_M)
        for place in self._places(kind, right_m, reach_m):
            place.location = self._grounded(place.location)
            lift_m = next((up for start, up in _LIFTS_M if name.startswith(start)), LIFT_M)
            signals = {"gesture": self._gestures.choice(GESTURES)} if kind is ObjectKind.FLAGGER else {}
            member = self._cast.spawn(name, place, role="crowd", lift_m=lift_m, **signals)
            if member is not None:
                reach_m = min(math.hypot(member.half_length_m, member.half_width_m), reach_m)
                self._taken.append((place.location.x, place.location.y, reach_m))
                self._settle(member, kind)
                return

    def _gather(self) -> _Walkers | None:
        """Spawn a group of pedestrians beside the road or in a lane.

        It returns the group if it walks; None if there is no space.
        """
        random, names = self._random, self._kinds.get(ObjectKind.PEDESTRIAN, [])

        def right_m(here: carla.Waypoint) -> float:
            return random.choice((-1, 1)) * random.uniform(*pedestrian_groups.ASIDE) * here.lane_width

        center = next(self._places(ObjectKind.PEDESTRIAN, right_m, pedestrian_groups.REACH_M), None) if names else None
        if center is None:
            return None
        ahead, right = center.get_forward_vector(), center.get_right_vector()
        members = []
        for aside_m, ahead_m in pedestrian_groups.places_of_a_group(random):
            at = self._grounded(center.location + right * aside_m + ahead * ahead_m)
            place = carla.Transform(at, carla.Rotation(yaw=random.uniform(-180.0, 180.0)))
            member = self._cast.spawn(random.choice(names), place, role="crowd", lift_m=WALKER_LIFT_M)
            if member is not None:
                members.append(member)
        self._taken.append((center.location.x, center.location.y, pedestrian_groups.REACH_M))
        walks = random.random() >= pedestrian_groups.STANDS
        return _Walkers(members) if members and walks else None

    def _places(
        self, kind: ObjectKind, right_m: Callable[[carla.Waypoint], float], reach_m: float
    ) -> Iterator[carla.Transform]:
        """Yield random free positions along the route; end after some tries."""
        for _ in range(_TRIES):
            here = self._setting.route.waypoint_at(self._random.uniform(FIRST_M, self._end_m))
            place = self._spot(here, right_m(here), kind)
            if not self._is_free(place.location, reach_m):
                continue
            if self._flows and kind not in LOW and self._is_in_lane(place.location, reach_m):
                continue
            yield place

    def _spot(self, here: carla.Waypoint, right_m: float, kind: ObjectKind) -> carla.Transform:
        """Return a pose next to a waypoint: vehicles mostly along the road, all other objects with a random heading."""
        transform, aside = here.transform, here.transform.get_right_vector()
        shift = self._random.uniform(-3.0, 3.0)
        ahead = transform.get_forward_vector()
        at = transform.location + aside * right_m + ahead * shift
        along = self._random.choice((0.0, 0.0, 0.0, 180.0)) + self._random.gauss(0.0, 6.0)
        arbitrary = self._random.uniform(-180.0, 180.0)
        turn = along if kind in ON_WHEELS and self._random.random() < 0.8 else arbitrary
        return carla.Transform(at, carla.Rotation(yaw=transform.rotation.yaw + turn))

    def _grounded(self, at: Any) -> carla.Location:
        """Return the position at ground height (a sidewalk is higher than the road); unchanged without ground."""
        above = carla.Location(at.x, at.y, at.z + _ABOVE_M)
        world: Any = self._setting.world  # the client's stub lacks this call
        met = world.ground_projection(above, 2.0 * _ABOVE_M)
        return carla.Location(at.x, at.y, at.z if met is None else met.location.z)

    def _is_free(self, at: carla.Location, reach_m: float) -> bool:
        return all(math.hypot(at.x - x, at.y - y) > reach_m + other + _APART_M for x, y, other in self._taken)

    def _is_in_lane(self, at: carla.Location, reach_m: float) -> bool:
        """True if an object of this size would narrow a lane for vehicles."""
        lane = self._setting.map.get_waypoint(at)
        center = lane.transform.location
        return math.hypot(at.x - center.x, at.y - center.y) < 0.5 * lane.lane_width + min(reach_m, 1.5)

    def _settle(self, member: ScenarioActor, kind: ObjectKind) -> None:
        """Set the behavior of a spawned actor."""
        if kind in ON_FEET:
            self._walkers.append(_Walkers([member]))
        elif kind in ON_WHEELS:
            self._cast.hold(member)
            self._lamped.append(_Lamped(member))
            if self._random.random() < DOOR_ODDS and member.actor.attributes.get("has_dynamic_doors") == "true":
                self._cast.open_door(member, getattr(carla.VehicleDoor, self._random.choice(_DOORS)))

    def _spawn_traffic(self) -> None:
        """Spawn driving vehicles of all blueprints on the route's lane and its neighbors."""
        setting, random = self._setting, self._random
        line = setting.route
        kinds = [kind for kind in ON_WHEELS if self._kinds.get(kind)]
        every_m = FLOWING_EVERY_M if self._flows else DRIVERS_EVERY_M
        s_m = -BEHIND_M if self._flows else FIRST_M + every_m
        while s_m < self._end_m:
            here = line.waypoint_at(max(s_m, 0.0))
            start = self._place_on_route(s_m)
            s_m += every_m * random.uniform(0.5, 1.5)
            if start is None or start.is_junction or not self._is_free(start.transform.location, 3.0):
                continue
            place = start.transform
            member = self._cast.spawn(random.choice(self._kinds[random.choice(kinds)]), place, role="crowd")
            if member is None:
                continue
            self._taken.append((place.location.x, place.location.y, member.half_length_m))
            self._lamped.append(_Lamped(member))
            is_adjacent = start.road_id != here.road_id or start.lane_id != here.lane_id
            self._cars[member.id] = setting.cars.drive(
                member,
                start,
                random.choice(WISH_MPS),
                # Beside the ego's lane nothing stops a vehicle in a free lane.
                constant=self._flows and is_adjacent,
                lane_chooser=random.choice,
                offset_m=random.uniform(-0.5, 0.5),
                obeys_lights=not self._flows,
            )

    def _place_on_route(self, s_m: float) -> carla.Waypoint | None:
        """Return a position in a lane at this arc length; negative ones lie behind the start."""
        line = self._setting.route
        if s_m >= 0.0:
            return self._some_lane(line.waypoint_at(s_m))
        behind = line.waypoint_at(0.0).previous(-s_m)
        return self._some_lane(self._random.choice(behind)) if behind else None

    def _some_lane(self, here: carla.Waypoint) -> carla.Waypoint:
        lanes = [here, here.get_left_lane(), here.get_right_lane()]
        return self._random.choice(
            [lane for lane in lanes if lane and lane.lane_type == carla.LaneType.Driving] or [here]
        )

    def _stroll(self, members: list[ScenarioActor]) -> None:
        """Make the walkers walk in one new direction, at one speed."""
        way = self._random.uniform(0.0, math.tau)
        if self._flows:
            # Along the road, so that no walker enters a lane.
            road = self._setting.map.get_waypoint(members[0].actor.get_location()).transform.rotation.yaw
            way = math.radians(road) + self._random.choice((0.0, math.pi))
        speed_mps = self._random.choice(WALK_MPS)
        for member in members:
            self._cast.walk(member, math.cos(way), math.sin(way), speed_mps)

    def _light_up(self, member: ScenarioActor) -> None:
        if member.actor.attributes.get("has_lights") != "true":
            return
        names = self._random.choice(_LAMPS)
        if member.actor.attributes.get("special_type") == "emergency" and self._random.random() < 0.6:
            names = (*names, *_SIREN)
        self._cast.lights(member, lamps(*names))
