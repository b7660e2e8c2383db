"""Situations from public reports: one class stages each of them from a row of `situation_rows`.

It notes marks for the judgment: the hero has `met` the situation, going became right (`free`), the hero has `passed`,
or `left` the place where it may not stop.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any, ClassVar

import carla

from stucksolver_eval.actors import Car, ScenarioActor
from stucksolver_eval.actors.actor_pool import lamps
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.families.junction import JunctionScenario
from stucksolver_eval.scenarios.families.lane_places import edge_m, offset_pose, row_across, run_of_lane
from stucksolver_eval.scenarios.families.mistaken_lights import MistakenEgo, MistakenLight, PhantomLight
from stucksolver_eval.scenarios.families.obstacle import oncoming_flow
from stucksolver_eval.scenarios.families.situation_rows import (
    PARKED_LIFT_M,
    Actor,
    HeroPose,
    Move,
    Situation,
    state_at,
)
from stucksolver_eval.scenarios.families.stuck import FAR_M, PASSABLE_M, QUEUE_M, STANDING_MPS
from stucksolver_eval.scenarios.parameters import NumberParameter
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.parameter_draws import Draw, IntegerDraw
from stucksolver_eval.sites.reported_sites import AT_JUNCTION, FINDERS, ON_LANE, ONLY_IN
from stucksolver_eval.sites.suite_placement import SuitePlacement

ROUTE_M = 120.0
"""Length of a vehicle's first path (m). Ours."""
END_M = 10.0
"""Distance after which a situation ends (m). Ours."""
SETTLE_S = 0.2
"""Time to stand in a pose (s). Ours."""


class ReportedScenario(JunctionScenario):
    """Stages the row `situation`. It ends when the hero has passed, or with the drive."""

    situation: ClassVar[Situation]
    timeout_s = None
    starts = "present from the start; times count from the hero's arrival"
    distance_m = NumberParameter("distance", 42.0, "m")

    def needs(self, setting: ScenarioContext) -> str | None:
        if not self._at_junction:
            return None
        missing = super().needs(setting)
        if missing is None and self.situation.site == "lights" and not self.own_lights:
            missing = "the hero has no traffic light at its next junction"
        return missing

    # ---- staging

    def stage(self) -> None:
        self._members = [self._spawn(actor) for actor in self.situation.actors]
        if self.situation.closure:
            for pose in row_across(self.setting.map, self._lane(0.0)[0]):
                self.cast.must_spawn(self.situation.closure, pose, lift_m=0.0)
        self._cars: dict[int, Car] = {}
        self._state: dict[int, tuple[int, bool]] = {}
        self._sliding: dict[int, tuple[float, float]] = {}
        self._noted: set[str] = set()

    def _spawn(self, actor: Actor) -> ScenarioActor:
        options = {"gesture": actor.gesture} if actor.gesture else {}
        if actor.from_s:
            return self.cast.keep_below(actor.blueprint, **options)
        member = self.cast.must_spawn(actor.blueprint, self._pose(actor), lift_m=actor.origin_m, **options)
        if actor.blueprint.startswith("vehicle."):
            self.cast.hold(member)
            self.cast.lights(member, lamps("NONE", *actor.lamps))
        if actor.has_open_door:
            self.cast.open_door(member, carla.VehicleDoor.FL)
        return member

    def _pose(self, actor: Actor) -> carla.Transform:
        lane, ahead_m = self._lane(actor.ahead_m)
        return offset_pose(lane, self._right_m(lane, actor), ahead_m, turn_deg=actor.turn_deg)

    def _lane(self, ahead_m: float) -> tuple[carla.Waypoint, float]:
        """Return the lane at a position along it, and the distance that remains to go straight on from there (m)."""
        if self._at_junction:
            return self.setting.route.waypoint_at(self.place_s), ahead_m
        return self.setting.route.waypoint_at(self.place_s + ahead_m), 0.0

    @staticmethod
    def _right_m(lane: carla.Waypoint, actor: Actor) -> float:
        half_m = lane.lane_width / 2.0
        beside = lane.get_left_lane()
        left_m = lane.lane_width if beside is None else beside.lane_width
        if actor.origin == "road":
            return float(actor.right_m * (lane.lane_width + left_m) - half_m - left_m)
        origin_m = {
            "lane": 0.0,
            "edge": half_m,
            "curb": edge_m(lane),
            "left": -half_m - left_m / 2.0,
            "far": -half_m - left_m,
        }
        return float(origin_m[actor.origin] + actor.right_m)

    @property
    def _at_junction(self) -> bool:
        return self.situation.site in AT_JUNCTION

    @cached_property
    def place_s(self) -> float:
        """Arc length of the place (m): on the lane, at the hero's stop line, or at the entry of its junction."""
        if not self._at_junction:
            return self.s_at(self.distance_m)
        route = self.setting.route
        lines = [line.transform.location for light in self.own_lights for line in light.get_stop_waypoints()]
        found = [(route.project(at, self.junction.first), at) for at in lines]
        if not found:
            return self.entry_s
        index, _ = min(found, key=lambda item: route.waypoints[item[0]].transform.location.distance(item[1]))
        return float(route.s_m[index])

    def perceived(self, vehicle: Any) -> Any:
        if not self.situation.perceived:
            return vehicle
        self._now_s = 0.0
        if self._at_junction:
            return MistakenEgo(vehicle, [MistakenLight(light, self._perceived_state) for light in self.own_lights])
        return MistakenEgo(vehicle, [PhantomLight(self._lane(0.0)[0], self._perceived_state)])

    def _perceived_state(self) -> str:
        return state_at(self.situation.perceived, self._now_s)

    # ---- script

    def script(self) -> Iterator[None]:
        flow = self._traffic_around()
        for _ in self._play():
            if flow is not None:
                flow.tick()
            yield
        if flow is not None:
            flow.clear()

    def _traffic_around(self) -> Any:
        """Set up the traffic. Returns the oncoming flow, if there is one."""
        kind, traffic = self.situation.traffic, self.traffic
        if self._at_junction or self.situation.closure:
            traffic.handle_junction_scenario(stop_entries=kind != "busy")
        traffic.leave_space_in_front(self.place_s - self.setting.hero_s_m + self.situation.past_m + 60.0)
        if kind != "busy":
            traffic.change_opposite_behavior(active=False)
            traffic.clear_opposite()
        if kind in ("empty", "busy"):
            traffic.switch_route_sources(False)
            traffic.remove_behind()
        return oncoming_flow(self, self.distance_m, PASSABLE_M, least_reach_m=FAR_M) if kind == "oncoming" else None

    def _play(self) -> Iterator[None]:
        self._now_s = 0.0
        self._set_lights()
        yield from self.until(self._has_arrived)
        if self.situation.hero_pose is not None:
            self._put_hero(self.situation.hero_pose)
            yield from self.wait(SETTLE_S)
        self.note("met")
        met_s = self.cast.time_s
        while not self._is_over():
            self._now_s = self.cast.time_s - met_s
            self._set_lights()
            for index, actor in enumerate(self.situation.actors):
                self._move(index, actor)
            self._note_marks()
            yield
        self.free_lights()

    def _has_arrived(self) -> bool:
        row = self.situation
        queued = row.site == "lights" and row.hero_pose is None and self.hero.speed_mps < STANDING_MPS
        return self.gap_m(self.place_s) < (QUEUE_M if queued else row.near_m)

    def _is_over(self) -> bool:
        if self.situation.expected == "reroute":
            return False
        return self.at_route_end() or self.gap_m(self.place_s + self.situation.past_m + END_M) < 0.0

    def _note_marks(self) -> None:
        row = self.situation
        if row.free_s is not None and self._now_s >= row.free_s:
            self.note("free")
        if self.gap_m(self.place_s + row.past_m) < 0.0:
            self.note("passed")
        if row.zone_m is not None and self._is_outside(row.zone_m):
            self.note("left")

    def note(self, mark: str) -> None:
        """Report the first time of a mark for the judgment."""
        if mark not in self._noted:
            self._noted.add(mark)
            self.news.append(("mark", mark, 0.0))

    def _is_outside(self, zone_m: tuple[float, float]) -> bool:
        """Return True if no part of the hero is in the zone."""
        place = self._lane(0.0)[0].transform
        yaw_rad = math.radians(place.rotation.yaw)
        dx, dy = self.hero.x - place.location.x, self.hero.y - place.location.y
        along_m = dx * math.cos(yaw_rad) + dy * math.sin(yaw_rad)
        half_m = self.cast.hero_member.half_length_m
        return along_m + half_m < zone_m[0] or along_m - half_m > zone_m[1]

    def _put_hero(self, pose: HeroPose) -> None:
        lane, ahead_m = self._lane(pose.ahead_m)
        self.setting.hero.set_transform(offset_pose(lane, pose.right_m, ahead_m, PARKED_LIFT_M, pose.turn_deg))
        self.setting.hero.set_target_velocity(carla.Vector3D())

    def disturb(self, control: carla.VehicleControl) -> carla.VehicleControl:
        if self.situation.is_held and "met" in self._noted:
            return carla.VehicleControl(brake=1.0, hand_brake=True)
        return control

    def _set_lights(self) -> None:
        if not self.situation.lights:
            return
        state = state_at(self.situation.lights, self._now_s)
        if self._lit == state:
            return
        self._lit = state
        if state == "off":
            for light in self.lights:
                light.set_state(carla.TrafficLightState.Off)
            self.lights[0].freeze(True)
            self._held = True
        else:
            self.hold_lights(green=self.own_lights if state == "green" else [])

    _lit: str = ""

    # ---- motion

    def _move(self, index: int, actor: Actor) -> None:
        if self._now_s < actor.from_s:
            return
        if self._members[index].is_staged:
            self.cast.bring(self._members[index], self._pose(actor), actor.origin_m)
        now_s = self._now_s % actor.every_s if actor.every_s else self._now_s
        number = sum(move.at_s <= now_s for move in actor.moves) - 1
        if number < 0:
            return
        move = actor.moves[number]
        state = number, now_s < move.at_s + move.for_s
        if self._state.get(index) != state:
            self._state[index] = state
            self._begin(index, actor, move, move.speed_mps if state[1] else 0.0)
        if index in self._sliding:
            self._slide(index)

    def _begin(self, index: int, actor: Actor, move: Move, speed_mps: float) -> None:
        member = self._members[index]
        if move.is_gone:
            self.cars.remove([self._cars.pop(index)]) if index in self._cars else self.cast.remove([member])
            self._sliding.pop(index, None)
            return
        if move.lamps is not None:
            self.cast.lights(member, lamps("NONE", *move.lamps))
        yaw_rad = math.radians(self._lane(actor.ahead_m)[0].transform.rotation.yaw + move.turn_deg)
        x, y = math.cos(yaw_rad), math.sin(yaw_rad)
        if actor.blueprint.startswith("vehicle."):
            self._drive(index, actor, speed_mps)
        elif actor.blueprint.startswith("static."):
            self._sliding[index] = (speed_mps * x, speed_mps * y)
        else:
            self.cast.walk(member, x, y, speed_mps)

    def _drive(self, index: int, actor: Actor, speed_mps: float) -> None:
        """Let a vehicle drive along its lane; one that faces the hero drives in the direction of the oncoming lane."""
        if index not in self._cars:
            lane = self._lane(actor.ahead_m)[0]
            right_m = self._right_m(lane, actor)
            faces_hero = abs(actor.turn_deg) > 90.0
            beside = lane.get_left_lane() if faces_hero or actor.origin == "left" else None
            if beside is not None:
                right_m += (lane.lane_width + beside.lane_width) / 2.0
                lane, right_m = beside, -right_m if faces_hero else right_m
            path = {"merge": (right_m, actor.merge_m)} if actor.merge_m else {"offset_m": right_m}
            line = run_of_lane(lane, ROUTE_M)
            self._cars[index] = self.cars.drive(
                self._members[index], line, speed_mps, begin=False, obeys_lights=False, yields=actor.yields, **path
            )
        self._cars[index].wish_mps = speed_mps

    def _slide(self, index: int) -> None:
        """Move a prop by one tick."""
        member, (vx, vy) = self._members[index], self._sliding[index]
        here, dt_s = self.cast.state(member), self.setting.dt_s
        place = carla.Location(here.x + vx * dt_s, here.y + vy * dt_s, here.z)
        self.cast.teleport(member, carla.Transform(place, carla.Rotation(yaw=math.degrees(here.yaw_rad))))


def register(rows: Sequence[Situation]) -> None:
    """Register a scenario type for each row."""
    for row in rows:
        values: dict[str, Draw] = {"distance": IntegerDraw(40, 48)} if row.site in ON_LANE else {}
        suspends = {"blocked", "wrong_lane", *({"route_deviation"} if row.expected == "reroute" else ())}
        members = {
            "__doc__": row.about,
            "situation": row,
            "type": row.name,
            "placed": SuitePlacement("reported", row.id, FINDERS[row.site], values, ONLY_IN.get(row.site, "")),
            "expected": row.expected,
            "within_s": row.within_s,
            "suspends": frozenset(suspends),
            "blueprints": tuple(dict.fromkeys(filter(None, (*(actor.blueprint for actor in row.actors), row.closure)))),
        }
        scenario(type(row.name, (ReportedScenario,), members))
