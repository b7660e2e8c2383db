"""Implements a rule-based driver after the published behavior of CARLA's BehaviorAgent that can also follow a path."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from functools import partial
from typing import Any, ClassVar

import carla

from stucksolver_carla.drivers.behavior.acceleration_limits import USUAL, AccelerationLimits, EgoMotion
from stucksolver_carla.drivers.behavior.conflict_paths import UPSTREAM_M, JunctionConflicts, junction_conflicts
from stucksolver_carla.drivers.behavior.controllers import MAX_STEER, PedalController, SteerController
from stucksolver_carla.drivers.behavior.flow_speed import PacedAccelerationLimits, rear_flow_speed_mps
from stucksolver_carla.drivers.behavior.junction_yield import FREE, LOOK_MPS, EgoSpeeds, JunctionYield, YieldDecision
from stucksolver_carla.drivers.behavior.lane_graph import lane_graph
from stucksolver_carla.drivers.behavior.local_planner import LocalPlanner
from stucksolver_carla.drivers.behavior.nearby_objects import BODILESS, RANGE_M, NearbyObjects, bodies_around
from stucksolver_carla.drivers.behavior.options import DriverOptions
from stucksolver_carla.drivers.behavior.path import Path, PlanarPose
from stucksolver_carla.drivers.behavior.predictive_braking import slow_adjacent_vehicles, vehicles_pulling_out
from stucksolver_carla.drivers.behavior.profiles import STOPPED_MPS, profile_named
from stucksolver_carla.drivers.behavior.pull_out import (
    ROADSIDE_M,
    SIDE_MARGIN_M,
    accepted_gap_s,
    find_pull_out_path,
    is_traffic_approaching,
    moving_objects,
)
from stucksolver_carla.drivers.behavior.route_bodies import objects_on_route
from stucksolver_carla.drivers.behavior.route_line import rejoining_length
from stucksolver_carla.drivers.behavior.routing import trace_route
from stucksolver_carla.drivers.behavior.sensor_lane_changes import LineSituation, SensorLaneChanges
from stucksolver_carla.drivers.behavior.stop_signs import StopSignWatch, stop_places
from stucksolver_carla.drivers.behavior.swept_path import Hazard
from stucksolver_carla.drivers.behavior.traffic_light_stops import LightWatch, stop_lines
from stucksolver_carla.drivers.behavior.vehicle_model import vehicle_model
from stucksolver_carla.drivers.driver_interface import DrivePoint, RoutePoint

FOLLOW_MAX_STEER = 1.0
"""Maximum steer input on a set path: leaving from close behind an obstacle may require the full lock."""
DRIVABLE_PROPS = ("static.prop.dirtdebris",)
"""Type ids of loose dirt, which CARLA's agents ignore and every car drives over."""
_WRONG_WAY_MPS = -0.1
"""Speed below which the ego rolls against its driving direction (m/s). Ours."""
_AT_REST_MPS = 0.1
"""Speed below which the ego is at rest at the roadside (m/s). Ours."""
_DEFAULT_TICK_S = 0.05
"""Length of a tick if the client reports none (s): CARLA's usual 20 Hz."""


class BehaviorDriver:
    """Drives a `carla.Vehicle`; see `Driver`. `behavior` is `cautious`, `normal` or `aggressive`."""

    sees_m: ClassVar[float] = RANGE_M
    """Range within which objects are read (m)."""
    upstream_m: ClassVar[float] = UPSTREAM_M
    """Length of the roads to a junction on which its traffic is observed (m)."""

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
        self._limits = AccelerationLimits(self._profile, self._options, self._model, self._planner)
        self._perception = bodies_around(vehicle, self.sees_m, (*BODILESS, *DRIVABLE_PROPS))
        self._flow_limits = PacedAccelerationLimits(self._profile, self._options, self._model, self._planner)
        if self._perception.doubt_m > 0.0:
            self._limits = self._flow_limits
        self._side_margin_m = SIDE_MARGIN_M + self._perception.doubt_m
        self._steering = SteerController(self._model)
        self._pedals = PedalController()
        self._lights = LightWatch([])
        self._signs = StopSignWatch([], self._model.half_length)
        self._yield = self._make_yield([])
        self._lane_changes: SensorLaneChanges | None = None
        """Lane changes that wait for gaps. Sensor mode only."""
        self._follower_mps = 0.0
        """Speed of the follower in the ego's lane (m/s); 0 without one. Sensor mode only."""
        self._route: tuple[RoutePoint, ...] = ()
        self._holding = False
        self._hold_mps2 = self._options.follow_deceleration
        self._ignored: frozenset[int] = frozenset()
        self._is_pulling_out = False
        """True if the ego has started to return to its lane from the roadside."""
        self._has_clear_path = False
        """True if a path without stopped objects existed when the ego was last stopped at the roadside."""
        self._roadside_s = 0.0
        """Time stopped at the roadside (s)."""
        self._hazard: Hazard | None = None
        self._cleared_ids: frozenset[int] = frozenset()
        """Ids of objects that will have left the ego's path in time. A driver that chooses its line sets them."""

    @property
    def route(self) -> Sequence[RoutePoint]:
        """The whole planned route, including the points behind the ego."""
        return self._route

    @property
    def hazard(self) -> Hazard | None:
        """The nearest object in the path at the last step, which explains why the ego brakes."""
        return self._hazard

    @property
    def acceleration_mps2(self) -> float:
        """Maximum acceleration of the driver (m/s²)."""
        return self._profile.acceleration

    @property
    def lateral_error_m(self) -> float:
        """Offset of the ego's center from the driven line at the last step (m, right positive)."""
        return self._planner.where.lateral

    @property
    def path_left_m(self) -> float:
        """Length of the driven line ahead of the ego's center (m); 0 without a line."""
        path = self._planner.path
        return 0.0 if path is None else max(path.length - self._planner.where.s, 0.0)

    def set_destination(self, destination: Any, start: Any | None = None) -> None:
        """Plan a route between two `carla.Location`s, by default from the ego's.

        Raises:
            RouteError: No route exists.
        """
        origin = self._vehicle.get_location() if start is None else start
        self.set_route(trace_route(self._map, origin, destination))

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Drive a route.

        Raises:
            ValueError: The route is empty.
        """
        if not route:
            raise ValueError("a route must have at least one point; use hold() to stay stopped")
        motion = self._motion()
        self._route = tuple(route)
        self._planner.set_route(self._route, motion.pose, motion.speed)
        self._holding = False
        self._read_line()
        doubt_m = self._perception.doubt_m
        line = self._planner.route_line
        self._lane_changes = SensorLaneChanges(self._route, line, doubt_m) if doubt_m > 0.0 else None

    def _read_line(self) -> None:
        """Find the lights, stop signs and junctions of the route's line."""
        line = self._planner.route_line
        actors = self._world.get_actors()
        lights, signs = list(actors.filter("*traffic_light*")), list(actors.filter("*traffic.stop*"))
        self._lights = LightWatch([] if line is None else stop_lines(lights, line))
        sign_positions = [] if line is None else stop_places(signs, line.s, line.x, line.y, line.z)
        self._signs = StopSignWatch(sign_positions, self._model.half_length)
        conflicts: list[JunctionConflicts] = []
        if line is not None:
            graph = lane_graph(self._map)
            conflicts = junction_conflicts(self._route, line, graph, lights, sign_positions, self.upstream_m)
        self._yield = self._make_yield(conflicts)

    def done(self) -> bool:
        """Return True if the ego's center is within two meters of the end of its route."""
        return self._planner.arrived

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Drive `path` up to its end.

        Args:
            path: Points in CARLA's world frame.
            reverse: True to back up along the path.
            ignore: Ids of actors that do not count as obstacles.

        Raises:
            ValueError: The path has too few points, or invalid ones.
        """
        motion = self._motion()
        self._planner.follow(path, motion.pose, motion.z, reverse)
        self._ignored = frozenset(ignore)
        self._holding = False

    def hold(self, brake_mps2: float | None = None) -> None:
        """Brake to a stop and stay stopped, with this deceleration (m/s²); None takes that of a set path."""
        self._holding = True
        self._hold_mps2 = self._options.follow_deceleration if brake_mps2 is None else brake_mps2

    def release(self) -> None:
        """Drive the route again, from its nearest point ahead."""
        motion = self._motion()
        self._planner.release(motion.pose, motion.speed)
        if self._lane_changes is not None:
            self._lane_changes.forget_line()
        self._holding = False
        self._ignored = frozenset()

    def keep_up(self) -> None:
        """Update the position. Call this instead of `run_step` on a tick on which another driver drives."""
        motion = self._motion()
        self._planner.update(motion.pose)
        self._steering.observe(motion.speed, motion.yaw_rate)

    def run_step(self) -> carla.VehicleControl:
        """Return this tick's `carla.VehicleControl`, not applied."""
        motion = self._motion()
        self._planner.update(motion.pose)
        self._steering.observe(motion.speed, motion.yaw_rate)
        around = self._perception.read(motion.pose.x, motion.pose.y)
        self._choose_line(motion, around)
        is_beside = self._is_at_roadside
        self._is_pulling_out = self._is_pulling_out and is_beside
        self._roadside_s = self._roadside_s + self._tick_s() if is_beside and motion.speed < STOPPED_MPS else 0.0
        must_stay = is_beside and not self._may_pull_out(motion, around)
        path = self._planner.path
        if path is None:
            return self._control(0.0, -self._hold_mps2, motion)
        motion_ahead = motion.reversed_motion() if self._planner.reversing else motion
        wanted_mps2 = self._acceleration(path, motion_ahead, around)
        return self._control(
            self._steer(path, motion_ahead),
            min(wanted_mps2, -self._options.follow_deceleration) if must_stay else wanted_mps2,
            motion_ahead,
        )

    def _choose_line(self, motion: EgoMotion, around: NearbyObjects) -> None:
        """Choose the line before each step: the route. In sensor mode, change lanes only when a gap is accepted."""
        planner, line, profile = self._planner, self._planner.route_line, self._profile
        if self._lane_changes is None or line is None or planner.following or self._holding or planner.arrived:
            return
        bodies = objects_on_route(line, planner.route_s, around)
        limit_kmh, half_m = self._vehicle.get_speed_limit(), self._model.half_length
        self._follower_mps = rear_flow_speed_mps(bodies, planner.route_s, planner.beside_m, motion.speed, half_m)
        joined_mps = self._yield.flow_mps if self._yield.has_started else 0.0
        flow_mps = max(joined_mps, self._lane_changes.pace_mps)
        self._flow_limits.set_flow_speed(flow_mps, self._follower_mps, limit_kmh, self._tick_s())
        cruise = self._limits.top_speed(limit_kmh)
        speed = max(motion.speed, 0.0)
        situation = LineSituation(planner.route_s, planner.beside_m, speed, cruise, bodies, self._model)
        new_line = self._lane_changes.other_line(line, situation, profile.lateral_accel, profile.deceleration)
        if new_line is not None:
            planner.take(new_line, motion.pose)

    def _make_yield(self, conflicts: Sequence[JunctionConflicts]) -> JunctionYield:
        return JunctionYield(conflicts, self._profile, self._model, sensor_mode=self._perception.doubt_m > 0.0)

    @property
    def _is_at_roadside(self) -> bool:
        planner = self._planner
        intended_m = 0.0 if self._lane_changes is None else self._lane_changes.intended_offset_m(planner.route_s)
        on_route_line = planner.route_line is not None and not planner.following
        return on_route_line and abs(planner.beside_m - intended_m) > ROADSIDE_M

    def _may_pull_out(self, motion: EgoMotion, around: NearbyObjects) -> bool:
        """Return True if the ego may return to its lane now. While it is stopped, search a path for that as well."""
        planner, line = self._planner, self._planner.route_line
        if line is None or planner.arrived:
            return True
        if motion.speed < STOPPED_MPS:
            gentle_m = rejoining_length(planner.beside_m, 0.0)
            rejoin_paths = partial(planner.way_back, motion.pose)
            path = find_pull_out_path(rejoin_paths, gentle_m, motion.pose, around, self._model, self._side_margin_m)
            self._has_clear_path = path is not None
            if path is not None:
                planner.take(path, motion.pose)
        # After the start in a gap the ego continues, because a stop half-way out would be worse.
        if motion.speed < _AT_REST_MPS or not self._is_pulling_out:
            gap_s = accepted_gap_s(self._roadside_s)
            # With sensor-based perception gaps are narrower, so plans end at the roadside more often. A stopped object
            # alongside in the ego's lane has just been passed there, and waiting for it would never end.
            ignores_stopped = self._has_clear_path and self._perception.doubt_m > 0.0
            objects = moving_objects(around) if ignores_stopped else around
            s, speed = planner.route_s, motion.speed
            self._is_pulling_out = not is_traffic_approaching(line, s, speed, objects, self._model, gap_s)
        return self._is_pulling_out

    def _steer(self, path: Path, motion_ahead: EgoMotion) -> float:
        speed, where = max(motion_ahead.speed, 0.0), self._planner.where
        if motion_ahead.speed < _WRONG_WAY_MPS:
            return self._steering.straighten()
        if not self._planner.reversing:
            tight = self._planner.following or self._is_at_roadside
            limit = FOLLOW_MAX_STEER if tight else MAX_STEER
            return self._steering.step(path, where, speed, limit)
        pose, reach = motion_ahead.pose, self._model.rear_axle
        axle = PlanarPose(pose.x + reach * math.cos(pose.yaw), pose.y + reach * math.sin(pose.yaw), pose.yaw)
        return self._steering.step_backwards(path, path.project(axle, where.s), speed, FOLLOW_MAX_STEER)

    def _acceleration(self, path: Path, motion_ahead: EgoMotion, around: NearbyObjects) -> float:
        """Return the lowest acceleration of all concerns (m/s²)."""
        speed, concerns = motion_ahead.speed, self._limits
        controls_mps2 = self._control_limit_mps2(speed)
        decision = self._yield_decision(speed, around, is_stopped_anyway=controls_mps2 < math.inf)
        brisk = self._yield.pace if self._yield.has_started else USUAL
        ignored_ids = self._ignored | decision.passing | self._cleared_ids
        margin = self._side_margin_m if self._is_at_roadside else None
        heeds = self._options.heeds_on_path or not self._planner.following
        candidates = concerns.hazards(path, motion_ahead, around, margin, self._perception.doubt_m) if heeds else []
        candidates += self._pulling_out_hazards(path, around, speed)
        hazards = [hazard for hazard in candidates if hazard.actor_id not in ignored_ids]
        self._hazard = min(hazards, key=lambda hazard: hazard.gap, default=None)
        allowed = [
            concerns.cruise(path, speed, self._vehicle.get_speed_limit(), self._command(), brisk),
            concerns.end(path, speed),
            controls_mps2,
            math.inf if decision.wait_m is None else concerns.wait(decision.wait_m, speed),
            math.inf if decision.leader is None else concerns.behind(*decision.leader, speed),
            math.inf if decision.look_m is None else concerns.slow_to(LOOK_MPS, decision.look_m, speed),
            -self._hold_mps2 if self._holding else math.inf,
            self._gap_wait_mps2(speed),
        ]
        if self._perception.doubt_m > 0.0:
            allowed += [concerns.halt(hazard, speed) for hazard in hazards]
        return min(allowed + [concerns.hazard(hazard, speed) for hazard in hazards])

    def _gap_wait_mps2(self, speed: float) -> float:
        """Return the acceleration while the ego waits for a gap in the adjacent lane (m/s²). Sensor mode only."""
        if self._lane_changes is None or self._planner.following:
            return math.inf
        return self._lane_changes.allowed_acceleration(self._limits, speed, self._follower_mps)

    def _pulling_out_hazards(self, path: Path, around: NearbyObjects, speed: float) -> list[Hazard]:
        """Return vehicles that are pulling out into the path. Sensor mode only.

        Braking later, when they are in the path, would be too late.
        """
        if self._lane_changes is None or self._planner.following:
            return []
        projection = self._planner.where
        bodies = objects_on_route(path, projection.s, around)
        # Relative to a line that leads into their lane, vehicles there would seem to pull out.
        objects = bodies.part(~bodies.has_id_in(self._lane_changes.entered_lane_ids))
        hazards_found = vehicles_pulling_out(objects, projection, self._model, speed)
        slow_hazards = slow_adjacent_vehicles(bodies, projection, self._model)
        return hazards_found + [hazard for hazard in slow_hazards if self._is_off_lanes(around, hazard.actor_id)]

    def _is_off_lanes(self, around: NearbyObjects, actor_id: int) -> bool:
        """Return True if an object is outside all driving lanes."""
        k = around.actor_id.index(actor_id)
        location = carla.Location(float(around.x[k]), float(around.y[k]), float(around.bottom[k]))
        return self._map.get_waypoint(location, project_to_road=False) is None

    def _yield_decision(self, speed: float, around: NearbyObjects, is_stopped_anyway: bool) -> YieldDecision:
        """Return the decision for the next junction of the route; none on a set path, which its planner has checked.

        `is_stopped_anyway`: True if a light or a stop sign already stops the ego.
        """
        planner = self._planner
        if is_stopped_anyway:
            self._yield.stay()
            return FREE
        line = planner.route_line
        if line is None or planner.following or self._holding:
            return FREE
        paced = self._limits is self._flow_limits
        limit_kmh = self._vehicle.get_speed_limit()
        top = self._flow_limits.own_top_speed(limit_kmh) if paced else self._limits.top_speed(limit_kmh)
        return self._yield.decide(line, planner.route_s, EgoSpeeds(speed, top), around, self._tick_s())

    def _control_limit_mps2(self, speed: float) -> float:
        """Return the acceleration that lights and stop signs allow (m/s²)."""
        planner, options = self._planner, self._options
        ignores_controls = planner.following and not options.follow_obeys_lights
        if ignores_controls or planner.reversing:
            return math.inf
        front = planner.route_s + self._model.half_length
        lights = math.inf if options.ignore_traffic_lights else self._light_limit_mps2(front, speed)
        return min(self._sign_limit_mps2(front, speed), lights)

    def _sign_limit_mps2(self, front: float, speed: float) -> float:
        distance = self._signs.distance_to_stop(front, speed, self._tick_s())
        if distance is None:
            return math.inf
        return self._limits.stop_line(distance, speed, self._signs.gap_m(self._options.stop_line_gap_m))

    def _light_limit_mps2(self, front: float, speed: float) -> float:
        distance = self._lights.distance_to_stop(front, speed, self._profile.deceleration, self._ignored)
        if distance is not None:
            return self._limits.stop_line(distance, speed)
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
        location, yaw = transform.location, math.radians(transform.rotation.yaw)
        speed = velocity.x * math.cos(yaw) + velocity.y * math.sin(yaw)
        yaw_rate = math.radians(self._vehicle.get_angular_velocity().z)
        return EgoMotion(PlanarPose(location.x, location.y, yaw), location.z, speed, yaw_rate)

    def _tick_s(self) -> float:
        return self._world.get_snapshot().timestamp.delta_seconds or _DEFAULT_TICK_S

    def _control(self, steer: float, acceleration: float, motion_ahead: EgoMotion) -> carla.VehicleControl:
        # The ego must stop before the gear changes, while it still rolls in the opposite direction.
        rolls_opposite = motion_ahead.speed < _WRONG_WAY_MPS
        wanted_mps2 = -self._options.follow_deceleration if rolls_opposite else acceleration
        pedals = self._pedals.step(wanted_mps2, abs(motion_ahead.speed), self._tick_s())
        reverse = self._planner.reversing != rolls_opposite
        return carla.VehicleControl(throttle=pedals.throttle, steer=steer, brake=pedals.brake, reverse=reverse)
