"""A rule-based driver after the published behaviour of CARLA's BehaviorAgent that can also be told a path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import carla

from stucksolver.stacks.driver.behavior import (
    cruise_speed,
    emergency,
    look_ahead,
    profile_named,
    toward_gap,
    toward_speed,
    turn_speed,
    wanted_gap,
)
from stucksolver.stacks.driver.controllers import MAX_STEER, PedalController, SteerController
from stucksolver.stacks.driver.hazards import WALKER_MARGIN_M, Hazard, nearest_hazards, sweep
from stucksolver.stacks.driver.interface import DrivePoint, RoutePoint
from stucksolver.stacks.driver.lights import LightWatch, stop_lines
from stucksolver.stacks.driver.local_planner import LocalPlanner
from stucksolver.stacks.driver.path import Path, Pose
from stucksolver.stacks.driver.perception import Perception
from stucksolver.stacks.driver.routing import trace_route
from stucksolver.stacks.driver.vehicle_model import vehicle_model

DEFAULT_LIMIT_KMH = 30.0
_SPEED_PREVIEW_S = 0.4
_DEFAULT_TICK_S = 0.05


@dataclass(frozen=True)
class DriverOptions:
    """What may be changed about a driver without changing its behaviour profile."""

    ignore_traffic_lights: bool = False
    follow_obeys_lights: bool = True
    """Stop at red lights of the route while driving a given path, too."""
    side_margin_m: float = 0.3
    """Clearance to either side of the body that the route's lane must have."""
    follow_side_margin_m: float = 0.2
    """The same on a given path: what is 0.3 m beside it never stops the ego."""
    follow_gap_m: float = 1.5
    """Bumper gap kept to what stands in a given path."""
    follow_deceleration: float = 3.0
    """Comfortable braking on a given path (m/s²)."""
    stop_line_gap_m: float = 1.0
    """Distance from the front bumper to a red light's stop line."""


@dataclass(frozen=True)
class _Motion:
    """The ego at one tick."""

    pose: Pose
    z: float
    speed: float
    """Along the body's heading (m/s)."""
    yaw_rate: float


class BehaviorDriver:
    """Drives a `carla.Vehicle`; see `Driver`. `behavior` is `cautious`, `normal` or `aggressive`."""

    def __init__(
        self,
        vehicle: Any,
        behavior: str = "normal",
        options: DriverOptions | None = None,
        carla_map: Any | None = None,
    ) -> None:
        self._vehicle = vehicle
        self._world = vehicle.get_world()
        self._map = self._world.get_map() if carla_map is None else carla_map
        self._options = options or DriverOptions()
        self._profile = profile_named(behavior)
        self._model = vehicle_model(vehicle)
        self._planner = LocalPlanner(self._profile.lateral_accel, self._profile.deceleration)
        self._perception = Perception(self._world, vehicle.id)
        self._steering = SteerController(self._model)
        self._pedals = PedalController()
        self._lights = LightWatch([])
        self._route: tuple[RoutePoint, ...] = ()
        self._holding = False
        self._hazard: Hazard | None = None

    @property
    def route(self) -> Sequence[RoutePoint]:
        """The whole planned route, points already passed included."""
        return self._route

    @property
    def hazard(self) -> Hazard | None:
        """The nearest body in the path at the last step, for those who want to know why the ego brakes."""
        return self._hazard

    @property
    def path_left_m(self) -> float:
        """Length of the line being driven that is still ahead of the ego's centre; 0 where there is none."""
        path = self._planner.path
        return 0.0 if path is None else max(path.length - self._planner.where.s, 0.0)

    def set_destination(self, destination: Any, start: Any | None = None) -> None:
        """Plan a route between two `carla.Location`s, by default from the ego's. Raises `RouteError`."""
        origin = self._vehicle.get_location() if start is None else start
        self.set_route(trace_route(self._map, origin, destination))

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Drive a route planned elsewhere. Raises `ValueError` for an empty one."""
        if not route:
            raise ValueError("a route needs at least one point; use hold() to stand still")
        motion = self._motion()
        self._route = tuple(route)
        self._planner.set_route(self._route, motion.pose, motion.speed)
        self._holding = False
        line = self._planner.route_line
        lights = self._world.get_actors().filter("*traffic_light*")
        self._lights = LightWatch([] if line is None else stop_lines(list(lights), line))

    def done(self) -> bool:
        """True once the ego's centre is within two metres of the end of its route."""
        return self._planner.arrived

    def follow(self, path: Sequence[DrivePoint]) -> None:
        """Drive `path` in place of the route, no further than its end. Raises `ValueError` for a bad path."""
        motion = self._motion()
        self._planner.follow(path, motion.pose, motion.z)
        self._holding = False

    def hold(self) -> None:
        """Brake to a stop and stay stopped."""
        self._holding = True

    def release(self) -> None:
        """Drive the route again, from the nearest point of it that lies ahead."""
        motion = self._motion()
        self._planner.release(motion.pose, motion.speed)
        self._holding = False

    def run_step(self) -> Any:
        """Decide this tick's `carla.VehicleControl`; does not apply it."""
        motion = self._motion()
        self._planner.update(motion.pose)
        self._steering.observe(motion.speed, motion.yaw_rate)
        path = self._planner.path
        if path is None:
            return self._control(0.0, -self._options.follow_deceleration, motion)
        limit = 1.0 if self._planner.following else MAX_STEER
        steer = self._steering.step(path, self._planner.where, motion.speed, limit)
        return self._control(steer, self._acceleration(path, motion), motion)

    def _acceleration(self, path: Path, motion: _Motion) -> float:
        """The lowest acceleration (m/s²) that anything allows."""
        speed = motion.speed
        allowed = [self._toward_cruise(path, speed), self._toward_end(path, speed)]
        if self._holding:
            allowed.append(-self._options.follow_deceleration)
        if not self._options.ignore_traffic_lights:
            allowed.append(self._for_lights(speed))
        hazards = self._hazards(path, motion)
        self._hazard = hazards[0] if hazards else None
        allowed.extend(self._for_hazard(hazard, speed) for hazard in hazards)
        return min(allowed)

    def _toward_cruise(self, path: Path, speed: float) -> float:
        bound = path.speed_at(self._planner.where.s + speed * _SPEED_PREVIEW_S)
        if not self._planner.following:
            limit = self._vehicle.get_speed_limit() or DEFAULT_LIMIT_KMH
            bound = min(bound, cruise_speed(self._profile, limit))
            if self._command() in ("left", "right"):
                bound = min(bound, turn_speed(limit))
        return toward_speed(speed, bound, self._profile)

    def _toward_end(self, path: Path, speed: float) -> float:
        return toward_gap(speed, path.length - self._planner.where.s, 0.0, self._deceleration)

    def _for_lights(self, speed: float) -> float:
        if self._planner.following and not self._options.follow_obeys_lights:
            return math.inf
        front = self._planner.route_s + self._model.half_length
        distance = self._lights.distance_to_stop(front, speed, self._profile.deceleration)
        if distance is None:
            stop_now = self._lights.unlisted_red(self._vehicle, self._map)
            return -self._profile.deceleration if stop_now else math.inf
        return toward_gap(speed, distance - self._options.stop_line_gap_m, 0.0, self._profile.deceleration)

    def _hazards(self, path: Path, motion: _Motion) -> list[Hazard]:
        following, options = self._planner.following, self._options
        reach = max(SteerController.MIN_REACH_M, SteerController.REACH_S * motion.speed)
        ahead = look_ahead(self._profile, motion.speed)
        swept = sweep(path, self._planner.where, motion.pose, self._model, reach, ahead)
        around = self._perception.read(motion.pose.x, motion.pose.y)
        margin = options.follow_side_margin_m if following else options.side_margin_m
        return nearest_hazards(swept, around, self._model, margin, margin if following else WALKER_MARGIN_M)

    def _for_hazard(self, hazard: Hazard, speed: float) -> float:
        hard = emergency(speed, hazard.gap, hazard.speed)
        if hard is not None:
            return hard
        profile, following = self._profile, self._planner.following
        standing = self._options.follow_gap_m if following else profile.braking_distance_m
        room = hazard.gap - wanted_gap(profile, standing, hazard.speed)
        return toward_gap(speed, room, hazard.speed, self._deceleration, profile.speed_decrease_kmh / 3.6)

    @property
    def _deceleration(self) -> float:
        following = self._planner.following
        return self._options.follow_deceleration if following else self._profile.deceleration

    def _command(self) -> str:
        line = self._planner.route_line
        if line is None:
            return ""
        index = int(self._planner.route_s / line.length * (len(self._route) - 1)) if line.length else 0
        return self._route[min(max(index, 0), len(self._route) - 1)].command

    def _motion(self) -> _Motion:
        transform, velocity = self._vehicle.get_transform(), self._vehicle.get_velocity()
        place, yaw = transform.location, math.radians(transform.rotation.yaw)
        speed = velocity.x * math.cos(yaw) + velocity.y * math.sin(yaw)
        yaw_rate = math.radians(self._vehicle.get_angular_velocity().z)
        return _Motion(Pose(place.x, place.y, yaw), place.z, speed, yaw_rate)

    def _control(self, steer: float, acceleration: float, motion: _Motion) -> Any:
        dt = self._world.get_snapshot().timestamp.delta_seconds or _DEFAULT_TICK_S
        pedals = self._pedals.step(acceleration, motion.speed, dt)
        return carla.VehicleControl(throttle=pedals.throttle, steer=steer, brake=pedals.brake)
