"""Simulated cars: each follows a `LanePath` at a target speed and keeps a distance to the vehicle ahead.

CARLA's TrafficManager is not used. It needs several calls to the server per tick, and a race in its wake-up would break
the reproducibility of a run from its seed. Car following is the Intelligent Driver Model (Treiber, Hennecke, Helbing
2000) with a linear free-road term; steering is pure pursuit (Coulter 1992). A `constant` car holds its speed in spite
of objects in its path, like the flows of CARLA's scenario_runner, until it has touched the hero. After that it drives
like the others. The others yield to it at junctions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import carla

from stucksolver_bridge.traffic_side import drives_on_left
from stucksolver_eval.actors.actor_pool import ActorPool, ActorState, ScenarioActor
from stucksolver_eval.actors.lane_path import Chooser, LanePath, StopLines, stop_lines
from stucksolver_eval.actors.lead_vehicles import Leader, boxes_touch, find_leaders
from stucksolver_eval.actors.reservations import JunctionReservations
from stucksolver_eval.actors.vehicle_control import BodyPedals, Steering

HORIZON_M = 56.0
"""Length of path ahead that is extended and checked for lights (m). Ours."""
LEADERS_EVERY = 3
"""Ticks between two searches for the lead vehicle. In between, its gap is extrapolated with the closing speed. Ours."""
MOST_MPS2 = 2.2
"""Largest acceleration (m/s²), `a` of the IDM. Ours."""
SOFT_MPS2 = 2.5
"""Comfortable deceleration (m/s²), `b` of the IDM. Ours."""
HARD_MPS2 = 8.0
"""Largest deceleration (m/s²). Ours."""
HEADWAY_S = 1.2
"""Time headway (s), `T` of the IDM. Ours."""
STAND_GAP_M = 4.0
"""Gap to a stopped lead vehicle (m). Ours."""
STOP_LINE_GAP_M = 1.5
"""Distance between the front bumper and a stop line (m). Ours."""
_YELLOW_MPS2 = 3.0
"""Deceleration up to which a car stops at a yellow light (m/s²). Ours."""
_CLAIM_M = 10.0
"""Distance at which a car reserves a junction, in addition to its braking distance (m). Ours."""
_PRESSES_S = 6.0
"""Time before its arrival at which a constant car reserves a junction (s).

No other car may enter from then on. Ours.
"""
_LIGHT_WITHIN_M = 3.0
"""Largest distance of a stop line inside its junction (m). Ours."""
_TOUCH_M = 0.05
"""Distance of two boxes that counts as contact (m). Ours."""
_SPEED_GAIN = 1.2
"""Gain of the free-road term (1/s). Ours."""
_LOW_M = 0.4
"""Height up to which objects are driven over (m). Ours."""


@dataclass(eq=False)
class Car:
    """One car. Its owner may change the target speed and the flags at any time. Arc lengths `s` are in meters."""

    member: ScenarioActor
    path: LanePath
    steering: Steering
    wish_mps: float
    """Target speed (m/s). At 0 the car brakes and waits."""
    brakes_hard: bool = False
    """True if the car brakes as in an emergency when its target speed is 0."""
    constant: bool = False
    obeys_lights: bool = True
    yields: bool = True
    """True if the car reacts to vehicles ahead and in the junction."""
    stand_gap_m: float = STAND_GAP_M
    start_road: int = 0
    """Id of the road on which its path starts."""
    number: int = 0
    """Number of cars that started before this one. Unlike the actor's id, it is the same in every run."""
    hit_hero: bool = False
    s: float = 0.0
    state: ActorState = field(default_factory=lambda: ActorState(0, 0, 0, 0, 0, 0, 0))
    leader: Leader | None = None
    pedals: BodyPedals = field(default_factory=BodyPedals)
    sent: tuple[float, float, float] = (-1.0, -1.0, -2.0)

    @property
    def done(self) -> bool:
        """True if the car has reached the end of its path."""
        return self.path.ended and self.path.s[-1] - self.s < 1.0

    @property
    def speed_mps(self) -> float:
        """Speed along the car's heading (m/s)."""
        return self.state.speed_mps

    @property
    def in_junction(self) -> bool:
        """True if any part of the car is in a junction of its path."""
        half = self.member.half_length_m
        return any(c.enter_s - half < self.s < c.leave_s + half for c in self.path.crossings)


class SimulatedCars:
    """All cars of a run. Call `step` once per tick, after target speeds have been set."""

    def __init__(self, cast: ActorPool, dt_s: float) -> None:
        self._cast, self._dt_s = cast, dt_s
        self._cars: dict[int, Car] = {}
        self._begun = 0
        self._steering: dict[str, Steering] = {}
        self._ticks = 0
        self.claims = JunctionReservations()

    @cached_property
    def stops(self) -> StopLines:
        """Stop lines of all traffic lights."""
        world = self._cast.hero_member.actor.get_world()
        return stop_lines(list(world.get_actors().filter("*traffic_light*")))

    def drive(
        self,
        member: ScenarioActor,
        start: Sequence[Any] | Any,
        wish_mps: float,
        *,
        constant: bool = False,
        lane_chooser: Chooser | None = None,
        ends: bool = False,
        offset_m: float = 0.0,
        merge: tuple[float, float] = (0.0, 0.0),
        obeys_lights: bool = True,
        yields: bool = True,
        begin: bool = True,
    ) -> Car:
        """Let a vehicle drive from a `carla.Waypoint`, or along several; see `LanePath` and `Car`.

        With `begin` it starts at its target speed, otherwise from rest.
        """
        waypoints = list(start) if isinstance(start, Sequence) else [start]
        path = LanePath(waypoints, lane_chooser, offset_m, merge, ends, self.stops)
        path.grow(HORIZON_M)
        steering = self._steering.get(member.type_id)
        if steering is None:
            steering = self._steering[member.type_id] = Steering.from_vehicle(member.actor, member.half_length_m)
        car = Car(
            member,
            path,
            steering,
            wish_mps,
            constant=constant,
            obeys_lights=obeys_lights,
            yields=yields and not constant,
        )
        car.state, car.start_road = self._cast.state(member), waypoints[0].road_id
        if constant:
            member.actor.enable_constant_velocity(carla.Vector3D(wish_mps, 0.0, 0.0))
        elif begin and wish_mps > 0.0:
            self._push(car, wish_mps)
        car.number, self._begun = self._begun, self._begun + 1
        self._cars[member.id] = car
        return car

    def redirect(self, car: Car, start: Any, merge: tuple[float, float] = (0.0, 0.0), **path: Any) -> None:
        """Give a car another path. `merge` describes the transition; see `LanePath`."""
        car.path = LanePath([start], merge=merge, stops=self.stops, **path)
        car.path.grow(HORIZON_M)
        self.claims.drop(car)

    def change_lane(self, car: Car, onto: Any, over_m: float) -> None:
        """Change to the lane of the waypoint `onto`, which is adjacent to the car, within `over_m` meters."""
        place, yaw = onto.transform.location, math.radians(onto.transform.rotation.yaw)
        here = car.state
        right_m = -(here.x - place.x) * math.sin(yaw) + (here.y - place.y) * math.cos(yaw)
        self.redirect(car, onto, (-right_m if drives_on_left(onto) else right_m, over_m))

    def let_go(self, car: Car) -> None:
        """Stop the control of a car. It keeps its last control; a constant velocity is switched off."""
        self._cars.pop(car.member.id, None)
        self.claims.drop(car)
        if car.constant:
            car.member.actor.disable_constant_velocity()

    def remove(self, cars: Sequence[Car]) -> None:
        """Remove cars from the world."""
        for car in cars:
            self._cars.pop(car.member.id, None)
            self.claims.drop(car)
        self._cast.remove([car.member for car in cars])

    def relax(self, car: Car) -> None:
        """Turn a constant car into one that brakes for vehicles ahead."""
        if car.constant:
            car.constant, car.yields = False, True
            car.member.actor.disable_constant_velocity()

    def slow(self, car: Car, speed_mps: float) -> None:
        """Set a car's target speed (m/s). A constant car has it immediately."""
        if car.constant and car.wish_mps != speed_mps:
            car.member.actor.enable_constant_velocity(carla.Vector3D(speed_mps, 0.0, 0.0))
        car.wish_mps = speed_mps

    def step(self) -> None:
        """Compute and send every car's control from this tick's snapshot."""
        self._ticks += 1
        cars = list(self._cars.values())
        for car in cars:
            car.state = self._cast.state(car.member)
            car.s = car.path.advance(car.state.x, car.state.y)
            car.path.grow(car.s + HORIZON_M)
            if car.constant:
                self._press_on(car)
                if not car.hit_hero:
                    self._feel(car)
        self._look_ahead([car for car in cars if car.yields and not car.constant])
        for car in cars:
            self._control(car)

    def _push(self, car: Car, speed_mps: float) -> None:
        """Give a car its initial speed."""
        yaw = car.state.yaw_rad
        velocity = carla.Vector3D(speed_mps * math.cos(yaw), speed_mps * math.sin(yaw), 0.0)
        self._cast.send(carla.command.ApplyTargetVelocity(car.member.id, velocity))

    def _look_ahead(self, cars: Sequence[Car]) -> None:
        for car in cars:
            if car.leader is not None:
                car.leader = car.leader.after(self._dt_s, car.state.speed_mps)
        self.find_leaders([car for car in cars if (car.number + self._ticks) % LEADERS_EVERY == 0])

    def find_leaders(self, cars: Sequence[Car]) -> None:
        """Find the vehicle ahead of each of these cars, and set their `leader`."""
        if cars:
            others = [self._cast.hero_member, *self._cast.members.values()]
            heeded = [other for other in others if not other.is_staged and 2.0 * other.half_height_m > _LOW_M]
            bodies = [(item, self._cast.state(item)) for item in heeded]
            find_leaders(cars, bodies)

    def _press_on(self, car: Car) -> None:
        """Reserve the junctions that a constant car will soon enter, because it does not brake for others."""
        front, rear = car.s + car.member.half_length_m, car.s - car.member.half_length_m
        for crossing in car.path.crossings:
            if crossing.leave_s < rear - 1.0:
                self.claims.release(car, crossing)
            elif crossing.enter_s - front < _PRESSES_S * max(car.wish_mps, car.state.speed_mps):
                self.claims.insist(car, crossing)

    def _feel(self, car: Car) -> None:
        """Turn a constant car that has touched the hero into an ordinary one."""
        hero, state = self._cast.hero, car.state
        if state.distance_m(hero.x, hero.y) > 8.0:
            return
        if boxes_touch(car.member, state, self._cast.hero_member, hero, _TOUCH_M):
            car.hit_hero = True
            self.relax(car)

    def _control(self, car: Car) -> None:
        speed = car.state.speed_mps
        steer = self._steer(car, speed)
        if car.constant:
            throttle, brake = 0.0, 0.0
        else:
            throttle, brake = car.pedals.step(self._acceleration(car, speed), abs(speed), self._dt_s)
        sent = car.sent
        if abs(throttle - sent[0]) + abs(brake - sent[1]) < 0.02 and abs(steer - sent[2]) < 0.003:
            return
        car.sent = (throttle, brake, steer)
        control = carla.VehicleControl(throttle=throttle, steer=steer, brake=brake)
        self._cast.send(carla.command.ApplyVehicleControl(car.member.id, control))

    def _steer(self, car: Car, speed: float) -> float:
        """Return the steering by pure pursuit from the rear axle."""
        state, steering = car.state, car.steering
        back = steering.wheelbase_m / 2.0
        cos, sin = math.cos(state.yaw_rad), math.sin(state.yaw_rad)
        rear_x, rear_y = state.x - back * cos, state.y - back * sin
        reach = max(4.0, 0.5 * speed) + back
        x, y = car.path.point(car.s - back + reach)
        dx, dy = x - rear_x, y - rear_y
        lateral = -dx * sin + dy * cos
        return steering.steer(2.0 * lateral / max(dx * dx + dy * dy, 4.0), abs(speed))

    def _acceleration(self, car: Car, speed: float) -> float:
        """Return the acceleration (m/s²): IDM behind the leader, and toward stop lines."""
        wish = min(car.wish_mps, car.path.speed_limit())
        if wish < 0.1:
            brake = HARD_MPS2 if car.brakes_hard else SOFT_MPS2
            return -brake if speed > 0.05 else -0.5
        free = min(max(_SPEED_GAIN * (wish - speed), -3.0), MOST_MPS2)
        wanted = free
        if car.leader is not None:
            gap = car.leader.gap_m - (car.stand_gap_m - 2.0)
            wanted = min(wanted, _idm(free, speed, gap, speed - car.leader.speed_mps))
        line_m = self._stop_in(car, speed)
        if line_m is not None:
            wanted = min(wanted, _idm(free, speed, line_m + 2.0, speed))
        return max(wanted, -HARD_MPS2)

    def _stop_in(self, car: Car, speed: float) -> float | None:
        """Return the distance from the bumper to the stop point (m): a light, or a junction that is not free."""
        front = car.s + car.member.half_length_m + STOP_LINE_GAP_M
        found: list[float] = []
        if car.obeys_lights:
            found += [line.s - front for line in car.path.lights if self._stops(line, line.s - front, speed)]
        held_m = min(found, default=math.inf)
        if car.yields and (claim_m := self._waits(car, front, speed, held_m)) is not None:
            found.append(claim_m)
        return min(found, default=None)

    def _stops(self, line: Any, ahead_m: float, speed: float) -> bool:
        if not -1.0 < ahead_m < HORIZON_M:
            return False
        state = line.light.state
        if state == carla.TrafficLightState.Red:
            return True
        return bool(state == carla.TrafficLightState.Yellow and speed * speed < 2.0 * _YELLOW_MPS2 * max(ahead_m, 0.1))

    def _waits(self, car: Car, front: float, speed: float, held_m: float) -> float | None:
        """Return the distance to a junction that others have reserved (m), or None.

        A car that waits at a light, `held_m` ahead, reserves nothing beyond it.
        """
        near_m = _CLAIM_M + 0.5 * speed * speed / SOFT_MPS2
        for crossing in car.path.crossings:
            if crossing.leave_s < car.s - car.member.half_length_m - 1.0:
                self.claims.release(car, crossing)
            elif crossing.enter_s - front > near_m:
                break
            elif held_m < crossing.enter_s - front + _LIGHT_WITHIN_M:
                self.claims.release(car, crossing)
                break
            elif not self.claims.claim(car, crossing) and crossing.enter_s - front > -1.5:
                return crossing.enter_s - front
        return None


def _idm(free: float, speed: float, gap: float, closing: float) -> float:
    wanted = 2.0 + max(HEADWAY_S * speed + speed * closing / (2.0 * math.sqrt(MOST_MPS2 * SOFT_MPS2)), 0.0)
    return free - MOST_MPS2 * (wanted / max(gap, 0.3)) ** 2
