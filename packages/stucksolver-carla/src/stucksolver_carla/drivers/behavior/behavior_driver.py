"""A rule-based driver after the published behavior of CARLA's BehaviorAgent that can also follow a given path."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from functools import partial
from typing import Any, ClassVar

import carla

from stucksolver_carla.drivers.behavior.acceleration_limits import USUAL, AccelerationLimits, EgoMotion
from stucksolver_carla.drivers.behavior.conflict_paths import UPSTREAM_M, JunctionConflicts, meetings
from stucksolver_carla.drivers.behavior.controllers import MAX_STEER, PedalController, SteerController
from stucksolver_carla.drivers.behavior.flow_speed import PacedAccelerationLimits, rear_flow_speed_mps
from stucksolver_carla.drivers.behavior.junction_yield import FREE, LOOKING_MPS, EgoSpeeds, JunctionYield, YieldDecision
from stucksolver_carla.drivers.behavior.lane_graph import lane_graph
from stucksolver_carla.drivers.behavior.local_planner import LocalPlanner
from stucksolver_carla.drivers.behavior.nearby_objects import BODILESS, RANGE_M, NearbyObjects, bodies_around
from stucksolver_carla.drivers.behavior.options import DriverOptions
from stucksolver_carla.drivers.behavior.path import Path, PlanarPose
from stucksolver_carla.drivers.behavior.predictive_braking import entering, slow_adjacent_vehicles
from stucksolver_carla.drivers.behavior.profiles import STANDING_MPS, profile_named
from stucksolver_carla.drivers.behavior.pull_out import (
    BESIDE_M,
    SIDE_MARGIN_M,
    accepted_gap_s,
    find_pull_out_path,
    is_traffic_approaching,
    moving,
)
from stucksolver_carla.drivers.behavior.route_bodies import on_route
from stucksolver_carla.drivers.behavior.route_line import rejoining_length
from stucksolver_carla.drivers.behavior.routing import trace_route
from stucksolver_carla.drivers.behavior.sensor_lane_changes import LineSituation, SensorLaneChanges
from stucksolver_carla.drivers.behavior.stop_signs import StopSignWatch, stop_places
from stucksolver_carla.drivers.behavior.swept_path import Hazard
from stucksolver_carla.drivers.behavior.traffic_light_stops import LightWatch, stop_lines
from stucksolver_carla.drivers.behavior.vehicle_model import vehicle_model
from stucksolver_carla.drivers.driver_interface import DrivePoint, RoutePoint

FOLLOW_MAX_STEER = 1.0
"""A swing-out from close behind an obstacle may need the full lock."""
DRIVEN_OVER = ("static.prop.dirtdebris",)
"""Loose dirt, which CARLA's agents do not even see and which every car drives over."""
_WRONG_WAY_MPS = -0.1
_HALTED_MPS = 0.1
_DEFAULT_TICK_S = 0.05


class BehaviorDriver:
    """Drives a `carla.Vehicle`; see `Driver`. `behavior` is `cautious`, `normal` or `aggressive`."""

    sees_m: ClassVar[float] = RANGE_M
    """How far it looks for bodies."""
    upstream_m: ClassVar[float] = UPSTREAM_M
    """How far up the roads that lead to a junction it looks for traffic."""

    def __init__(
        self,
        vehicle: carla.Vehicle,
        behavior: str = "normal",
        options: DriverOptions | None = None,
        carla_map: carla.Map | None = None,
    ) -> None:
        self._vehicle = vehicle
        self._world = vehicle.get_world()
        self._map = self._world.get_map() if carla_map is None else carla_map
        self._options = options or DriverOptions()
        self._profile = profile_named(behavior)
        self._model = vehicle_model(vehicle)
        self._planner = LocalPlanner(self._profile.lateral_accel, self._profile.deceleration)
        self._concerns = AccelerationLimits(self._profile, self._options, self._model, self._planner)
        self._perception = bodies_around(vehicle, self.sees_m, (*BODILESS, *DRIVEN_OVER))
        self._paced = PacedAccelerationLimits(self._profile, self._options, self._model, self._planner)
        if self._perception.doubt_m > 0.0:
            self._concerns = self._paced
        self._side_margin_m = SIDE_MARGIN_M + self._perception.doubt_m
        self._steering = SteerController(self._model)
        self._pedals = PedalController()
        self._lights = LightWatch([])
        self._signs = StopSignWatch([], self._model.half_length)
        self._give_way = self._giving_way([])
        self._changing: SensorLaneChanges | None = None
        """Its lane changes, by sensors."""
        self._behind_mps = 0.0
        """By sensors, the speed of who follows it in its lane (m/s); 0 if nobody does."""
        self._route: tuple[RoutePoint, ...] = ()
        self._holding = False
        self._hold_mps2 = self._options.follow_deceleration
        self._ignored: frozenset[int] = frozenset()
        self._leaving = False
        """True if it has decided to return to its lane from beside it."""
        self._clear = False
        """True if a way out was clear of what stands, when it last stood beside its lane."""
        self._beside_s = 0.0
        """How long it has stood beside its lane (s)."""
        self._hazard: Hazard | None = None
        self._out_of_the_way: frozenset[int] = frozenset()
        """Ids of those who are proven to be out of the way in time; a driver that chooses its line sets them."""

    @property
    def route(self) -> Sequence[RoutePoint]:
        """The whole planned route, including points already passed."""
        return self._route

    @property
    def hazard(self) -> Hazard | None:
        """The nearest body in the path at the last step, which explains why the ego brakes."""
        return self._hazard

    @property
    def acceleration_mps2(self) -> float:
        """Its highest acceleration (m/s²)."""
        return self._profile.acceleration

    @property
    def lateral_error_m(self) -> float:
        """Offset of the ego's center from the line it drives at the last step (m, right positive)."""
        return self._planner.where.lateral

    @property
    def path_left_m(self) -> float:
        """Length of the line that is still ahead of the ego's center (m); 0 without a line."""
        path = self._planner.path
        return 0.0 if path is None else max(path.length - self._planner.where.s, 0.0)

    def set_destination(self, destination: Any, start: Any | None = None) -> None:
        """Plan a route between two `carla.Location`s, by default from the ego's.

        Raises:
            RouteError: There is no route.
        """
        origin = self._vehicle.get_location() if start is None else start
        self.set_route(trace_route(self._map, origin, destination))

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Drive a route planned elsewhere.

        Raises:
            ValueError: The route is empty.
        """
        if not route:
            raise ValueError("a route needs at least one point; use hold() to stand still")
        motion = self._motion()
        self._route = tuple(route)
        self._planner.set_route(self._route, motion.pose, motion.speed)
        self._holding = False
        self._watch_line()
        doubt_m = self._perception.doubt_m
        self._changing = SensorLaneChanges(self._route, self._planner.route_line, doubt_m) if doubt_m > 0.0 else None

    def _watch_line(self) -> None:
        """Find the lights, stop signs and junctions of the route's line."""
        line = self._planner.route_line
        actors = self._world.get_actors()
        lights, signs = list(actors.filter("*traffic_light*")), list(actors.filter("*traffic.stop*"))
        self._lights = LightWatch([] if line is None else stop_lines(lights, line))
        places = [] if line is None else stop_places(signs, line.s, line.x, line.y, line.z)
        self._signs = StopSignWatch(places, self._model.half_length)
        met = (
            [] if line is None else meetings(self._route, line, lane_graph(self._map), lights, places, self.upstream_m)
        )
        self._give_way = self._giving_way(met)

    def done(self) -> bool:
        """True once the ego's center is within two meters of the end of its route."""
        return self._planner.arrived

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Drive `path`, no further than its end.

        Args:
            path: Points in CARLA's world frame.
            reverse: Back up along it.
            ignore: Ids of actors that are driven over.

        Raises:
            ValueError: The path cannot be driven.
        """
        motion = self._motion()
        self._planner.follow(path, motion.pose, motion.z, reverse)
        self._ignored = frozenset(ignore)
        self._holding = False

    def hold(self, brake_mps2: float | None = None) -> None:
        """Brake to a stop and stay stopped, with this deceleration (m/s²) or as on a path."""
        self._holding = True
        self._hold_mps2 = self._options.follow_deceleration if brake_mps2 is None else brake_mps2

    def release(self) -> None:
        """Drive the route again, from the nearest point of it that lies ahead."""
        motion = self._motion()
        self._planner.release(motion.pose, motion.speed)
        if self._changing is not None:
            self._changing.forget_line()
        self._holding = False
        self._ignored = frozenset()

    def keep_up(self) -> None:
        """Use instead of `run_step` on a tick on which someone else drives."""
        motion = self._motion()
        self._planner.update(motion.pose)
        self._steering.observe(motion.speed, motion.yaw_rate)

    def run_step(self) -> carla.VehicleControl:
        """Return this tick's `carla.VehicleControl`, not applied."""
        motion = self._motion()
        self._planner.update(motion.pose)
        self._steering.observe(motion.speed, motion.yaw_rate)
        around = self._perception.read(motion.pose.x, motion.pose.y)
        self._decide(motion, around)
        beside = self._at_the_roadside
        self._leaving = self._leaving and beside
        self._beside_s = self._beside_s + self._tick_s() if beside and motion.speed < STANDING_MPS else 0.0
        stays = beside and not self._pulls_out(motion, around)
        path = self._planner.path
        if path is None:
            return self._control(0.0, -self._hold_mps2, motion)
        way = motion.backwards() if self._planner.reversing else motion
        wanted = self._acceleration(path, way, around)
        return self._control(
            self._steer(path, way), min(wanted, -self._options.follow_deceleration) if stays else wanted, way
        )

    def _decide(self, motion: EgoMotion, around: NearbyObjects) -> None:
        """Called before each step, to choose the line: its route. By sensors, lanes are changed in gaps."""
        planner, line, profile = self._planner, self._planner.route_line, self._profile
        if self._changing is None or line is None or planner.following or self._holding or planner.arrived:
            return
        bodies = on_route(line, planner.route_s, around)
        limit_kmh, half_m = self._vehicle.get_speed_limit(), self._model.half_length
        self._behind_mps = rear_flow_speed_mps(bodies, planner.route_s, planner.beside_m, motion.speed, half_m)
        joined = self._give_way.flow_mps if self._give_way.going else 0.0
        self._paced.set_flow_speed(max(joined, self._changing.pace_mps), self._behind_mps, limit_kmh, self._tick_s())
        cruise = self._concerns.top_speed(limit_kmh)
        here = LineSituation(planner.route_s, planner.beside_m, max(motion.speed, 0.0), cruise, bodies, self._model)
        other = self._changing.other_line(line, here, profile.lateral_accel, profile.deceleration)
        if other is not None:
            planner.take(other, motion.pose)

    def _giving_way(self, met: Sequence[JunctionConflicts]) -> JunctionYield:
        return JunctionYield(met, self._profile, self._model, sensed=self._perception.doubt_m > 0.0)

    @property
    def _at_the_roadside(self) -> bool:
        planner = self._planner
        meant = 0.0 if self._changing is None else self._changing.meant_m(planner.route_s)
        return planner.route_line is not None and not planner.following and abs(planner.beside_m - meant) > BESIDE_M

    def _pulls_out(self, motion: EgoMotion, around: NearbyObjects) -> bool:
        """True if the ego may return to its lane now. While it stands, the way there is searched for as well."""
        planner, line = self._planner, self._planner.route_line
        if line is None or planner.arrived:
            return True
        if motion.speed < STANDING_MPS:
            gentle = rejoining_length(planner.beside_m, 0.0)
            ways = partial(planner.way_back, motion.pose)
            way = find_pull_out_path(ways, gentle, motion.pose, around, self._model, self._side_margin_m)
            self._clear = way is not None
            if way is not None:
                planner.take(way, motion.pose)
        # Once it has set off in a gap it goes on: stopping half-way out would be worse.
        if motion.speed < _HALTED_MPS or not self._leaving:
            gap_s = accepted_gap_s(self._beside_s)
            # What sensors see narrows the gaps, so that plans end in the lane beside more often. What stands abreast in
            # the own lane is what has been passed: it would be waited for forever.
            passed = self._clear and self._perception.doubt_m > 0.0
            others = moving(around) if passed else around
            self._leaving = not is_traffic_approaching(line, planner.route_s, motion.speed, others, self._model, gap_s)
        return self._leaving

    def _steer(self, path: Path, way: EgoMotion) -> float:
        speed, where = max(way.speed, 0.0), self._planner.where
        if way.speed < _WRONG_WAY_MPS:
            return self._steering.straighten()
        if not self._planner.reversing:
            tight = self._planner.following or self._at_the_roadside
            limit = FOLLOW_MAX_STEER if tight else MAX_STEER
            return self._steering.step(path, where, speed, limit)
        pose, reach = way.pose, self._model.rear_axle
        axle = PlanarPose(pose.x + reach * math.cos(pose.yaw), pose.y + reach * math.sin(pose.yaw), pose.yaw)
        return self._steering.step_backwards(path, path.project(axle, where.s), speed, FOLLOW_MAX_STEER)

    def _acceleration(self, path: Path, way: EgoMotion, around: NearbyObjects) -> float:
        """Return the lowest acceleration that anything allows (m/s²)."""
        speed, concerns = way.speed, self._concerns
        lines = self._for_lines(speed)
        crossing = self._others_first(speed, around, held=lines < math.inf)
        brisk = self._give_way.pace if self._give_way.going else USUAL
        unheeded = self._ignored | crossing.passing | self._out_of_the_way
        margin = self._side_margin_m if self._at_the_roadside else None
        heeds = self._options.heeds_on_path or not self._planner.following
        found = concerns.hazards(path, way, around, margin, self._perception.doubt_m) if heeds else []
        found += self._pulling_out(path, around, speed)
        hazards = [h for h in found if h.actor_id not in unheeded]
        self._hazard = min(hazards, key=lambda hazard: hazard.gap, default=None)
        allowed = [
            concerns.cruise(path, speed, self._vehicle.get_speed_limit(), self._command(), brisk),
            concerns.end(path, speed),
            lines,
            math.inf if crossing.wait_m is None else concerns.wait(crossing.wait_m, speed),
            math.inf if crossing.leader is None else concerns.behind(*crossing.leader, speed),
            math.inf if crossing.look_m is None else concerns.slow_to(LOOKING_MPS, crossing.look_m, speed),
            -self._hold_mps2 if self._holding else math.inf,
            self._waiting_for_a_lane(speed),
        ]
        if self._perception.doubt_m > 0.0:
            allowed += [concerns.halt(hazard, speed) for hazard in hazards]
        return min(allowed + [concerns.hazard(hazard, speed) for hazard in hazards])

    def _waiting_for_a_lane(self, speed: float) -> float:
        """By sensors, return the acceleration that waiting for a gap in the next lane allows."""
        if self._changing is None or self._planner.following:
            return math.inf
        return self._changing.allowed(self._concerns, speed, self._behind_mps)

    def _pulling_out(self, path: Path, around: NearbyObjects, speed: float) -> list[Hazard]:
        """By sensors, return who pulls out into the way from beside it: once it is in the way it is too late."""
        if self._changing is None or self._planner.following:
            return []
        where = self._planner.where
        seen = on_route(path, where.s, around)
        # Seen from a line that leads into their lane, those who drive there seem to pull out.
        others = seen.part(~seen.among(self._changing.entered))
        found = entering(others, where, self._model, speed)
        slow = slow_adjacent_vehicles(seen, where, self._model)
        return found + [item for item in slow if self._is_off_the_lanes(around, item.actor_id)]

    def _is_off_the_lanes(self, around: NearbyObjects, actor_id: int) -> bool:
        """True if a body is on no lane of moving traffic."""
        k = around.actor_id.index(actor_id)
        place = carla.Location(float(around.x[k]), float(around.y[k]), float(around.bottom[k]))
        return self._map.get_waypoint(place, project_to_road=False) is None

    def _others_first(self, speed: float, around: NearbyObjects, held: bool) -> YieldDecision:
        """Return who comes at the next junction of the route. On a given path whoever gave it has checked.

        `held`: a light or a stop sign stops the ego anyway.
        """
        planner = self._planner
        if held:
            self._give_way.stay()
            return FREE
        line = planner.route_line
        if line is None or planner.following or self._holding:
            return FREE
        paced = self._concerns is self._paced
        limit_kmh = self._vehicle.get_speed_limit()
        top = self._paced.own_top_speed(limit_kmh) if paced else self._concerns.top_speed(limit_kmh)
        return self._give_way.look(line, planner.route_s, EgoSpeeds(speed, top), around, self._tick_s())

    def _for_lines(self, speed: float) -> float:
        """Return what lights and stop signs allow."""
        planner, options = self._planner, self._options
        unbound = planner.following and not options.follow_obeys_lights
        if unbound or planner.reversing:
            return math.inf
        front = planner.route_s + self._model.half_length
        lights = math.inf if options.ignore_traffic_lights else self._for_lights(front, speed)
        return min(self._for_signs(front, speed), lights)

    def _for_signs(self, front: float, speed: float) -> float:
        distance = self._signs.distance_to_stop(front, speed, self._tick_s())
        if distance is None:
            return math.inf
        return self._concerns.stop_line(distance, speed, self._signs.gap_m(self._options.stop_line_gap_m))

    def _for_lights(self, front: float, speed: float) -> float:
        distance = self._lights.distance_to_stop(front, speed, self._profile.deceleration, self._ignored)
        if distance is not None:
            return self._concerns.stop_line(distance, speed)
        stop_now = self._lights.unlisted_red(self._vehicle, self._map)
        return -self._profile.deceleration if stop_now else math.inf

    def _command(self) -> str:
        line = self._planner.route_line
        if line is None:
            return ""
        index = int(self._planner.route_s / line.length * (len(self._route) - 1))
        return self._route[min(max(index, 0), len(self._route) - 1)].command

    def _motion(self) -> EgoMotion:
        transform, velocity = self._vehicle.get_transform(), self._vehicle.get_velocity()
        place, yaw = transform.location, math.radians(transform.rotation.yaw)
        speed = velocity.x * math.cos(yaw) + velocity.y * math.sin(yaw)
        yaw_rate = math.radians(self._vehicle.get_angular_velocity().z)
        return EgoMotion(PlanarPose(place.x, place.y, yaw), place.z, speed, yaw_rate)

    def _tick_s(self) -> float:
        return self._world.get_snapshot().timestamp.delta_seconds or _DEFAULT_TICK_S

    def _control(self, steer: float, acceleration: float, way: EgoMotion) -> carla.VehicleControl:
        # Still rolling the other way: stop before changing gear.
        turning_back = way.speed < _WRONG_WAY_MPS
        wanted = -self._options.follow_deceleration if turning_back else acceleration
        pedals = self._pedals.step(wanted, abs(way.speed), self._tick_s())
        reverse = self._planner.reversing != turning_back
        return carla.VehicleControl(throttle=pedals.throttle, steer=steer, brake=pedals.brake, reverse=reverse)
