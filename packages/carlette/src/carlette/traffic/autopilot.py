"""Cars that drive without a client: they follow lanes and lead vehicles, obey lights, and take turns at junctions.

The traffic is part of a world's state (`World.traffic`), so a fork continues it. Cars keep their lane. They do not
overtake, and change lanes only where lanes divide. All other objects (an ego, walkers, objects on the road) count with
their boxes at their present positions. Only cars of the same traffic take turns at junctions.

The numbers are ours.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats
from carlette.physics.bodies import BodyTable
from carlette.physics.vehicle_dynamics import BRAKE, STEER, THROTTLE
from carlette.traffic.idm import IdmParameters, free_acceleration, interaction
from carlette.traffic.junction_locks import Junctions
from carlette.traffic.lane_graph import lane_graph
from carlette.traffic.lane_point_grid import Ints, blocked_points
from carlette.traffic.routes import AHEAD_POINTS, RENEW_POINTS, ROW_POINTS, CarRoute
from carlette.traffic.stop_lines import stop_lines
from carlette.world.actor import ActorKind
from carlette.world.traffic_lights import Color
from carlette.world.world import World

SPEED_SHARE = 0.9
"""Target speed as a share of the speed limit."""
POINT_STEP_M = 1.0
"""Distance between two lane points (m)."""
LOOK_S, LEAST_LOOK_M, MOST_LOOK_M = 0.25, 1.5, 10.0
"""Distance of the steering point on the lane: time (s), smallest and largest value (m)."""
AMBER_MPS2 = 3.0
"""Deceleration above which a car continues at yellow instead of braking (m/s²)."""
RED_MPS2 = 7.0
"""Deceleration above which a car continues at red instead of braking (m/s²)."""
DECIDE_M = 8.0
"""Distance before a junction, beyond the braking distance, at which a car requests entry (m)."""
LEAST_SIGHT_M = 30.0
"""Sight distance at standstill (m)."""
STOP_NEAR_M = 3.5
"""Distance to the line within which a halt counts as the stop at a stop sign (m)."""
HALTED_MPS = 0.2
"""Speed below which a car counts as stopped (m/s)."""
ROOM_M = 3.0
"""Free space behind a junction, beyond the car's length, that a car requires to enter it (m)."""
BEFORE_GATE_M = 2.5
"""Space that a car waiting at a junction leaves for those that turn in front of it (m)."""
ROLLING_MPS = 4.0
"""Speed of the lead vehicle above which a car enters a junction without free space behind it (m/s)."""
HOLD_BRAKE = 0.4
"""Brake position of a stopped car (0 to 1)."""


@dataclass(frozen=True)
class TrafficView:
    """State of all cars on this tick; arrays with one row per car."""

    rows: Ints
    """Row in `BodyTable`."""
    index: Ints
    """Row in `Fleet`."""
    speed: Floats
    run: Floats
    """Distance of the car's center along its route (m)."""
    nose: Floats
    """Distance from the center to the front bumper (m)."""
    window: Ints
    """(cars, points ahead): positions in the car's row of the points ahead."""
    points: Ints
    """(cars, points ahead): lane points."""
    gap: Floats
    """(cars, points ahead): distance from the front bumper to each point (m)."""


class Traffic:
    """Drives some of a world's cars."""

    def __init__(self, world: World, ids: Iterable[int] | None = None, seed: int = 0) -> None:
        """Take over the vehicles `ids` (default: all) in their present state; `self.ids` are those on a lane."""
        self.graph = lane_graph(world.roads)
        self.lines = stop_lines(world, self.graph)
        self.driver = IdmParameters()
        self.ids: list[int] = []
        """Ids of the cars that the traffic drives."""
        self.routes: list[CarRoute] = []
        self.junctions = Junctions()
        wanted = (
            [actor.id for actor in world.actors.values() if actor.kind is ActorKind.VEHICLE]
            if ids is None
            else list(ids)
        )
        points = []
        for actor_id in wanted:
            row = world.actor(actor_id, "traffic").row
            point = self.graph.nearest(world.bodies.position[row], float(np.radians(world.bodies.rotation[row, 1])))
            if point >= 0:
                self.ids.append(actor_id)
                self.routes.append(CarRoute(self.graph, point, f"{seed} {actor_id}"))
                points.append(point)
        count = len(self.ids)
        self.at = np.zeros(count, np.int64)
        """Index of the present point in each car's row."""
        self.points = np.zeros((count, ROW_POINTS), np.int64)
        self.runs = np.zeros((count, ROW_POINTS))
        """Distance of each point on the car's route (m)."""
        self.speeds = np.zeros((count, ROW_POINTS))
        self.gate = np.full((count, 2), np.inf)
        """Start and end of the next junction that is not reserved (m)."""
        self.way_out = np.full(count, np.inf)
        """End of the reserved junction (m); infinite without one."""
        self.halted = np.full(count, -1)
        """Lane point of the stop line at which each car has stopped; -1 = none."""
        for car, point in enumerate(points):
            self._write_row(car, point, 0.0)
            self._begin_inside(car)

    # -- state

    def _write_row(self, car: int, point: int, run: float) -> None:
        graph, route = self.graph, self.routes[car]
        route.forget(int(graph.lane[point]))
        route.extend(graph, run + ROW_POINTS * POINT_STEP_M)
        points = route.points(graph, point)
        steps = np.hypot(*np.diff(graph.place[points, :2], axis=0).T)
        self.points[car] = points
        self.runs[car] = run + np.concatenate([[0.0], np.cumsum(steps)])
        speeds = SPEED_SHARE * graph.speed[points]
        speeds[1:][steps == 0.0] = 0.0
        self.speeds[car] = speeds
        self.at[car] = 0
        self._find_gate(car)

    def _find_gate(self, car: int) -> None:
        after_m = self.way_out[car] - 0.1 if car in self.junctions.held else float(self.runs[car, self.at[car]])
        begin, end, _ = self.routes[car].next_junction(self.graph, after_m)
        self.gate[car] = (begin, end)

    def _begin_inside(self, car: int) -> None:
        route, inside = self.routes[car], []
        for lane in route.lanes:
            if not self.graph.inside[lane]:
                break
            inside.append(lane)
        if inside:
            self.junctions.take(car, tuple(inside))
            self.way_out[car] = route.starts[len(inside)] if len(route.starts) > len(inside) else np.inf
            self._find_gate(car)

    # -- driving

    def step(self, world: World) -> None:
        """Set the controls of all its cars for the coming tick."""
        gone = [car for car, actor_id in enumerate(self.ids) if actor_id not in world.actors]
        for car in reversed(gone):
            self._drop(car)
        if not self.ids:
            return
        view = self._look(world)
        acceleration = self._accelerate(world, view)
        self._control(world, view, acceleration)

    def _drop(self, gone: int) -> None:
        keep = np.arange(len(self.ids)) != gone
        del self.ids[gone], self.routes[gone]
        for name in ("at", "points", "runs", "speeds", "gate", "way_out", "halted"):
            setattr(self, name, getattr(self, name)[keep])
        junctions = self.junctions
        junctions.leave(gone)
        junctions.held = {car - (car > gone): lanes for car, lanes in junctions.held.items()}
        junctions.waiting = {car - (car > gone): ticks for car, ticks in junctions.waiting.items() if car != gone}

    def _look(self, world: World) -> TrafficView:
        actors = [world.actors[object_id] for object_id in self.ids]
        rows = np.array([actor.row for actor in actors])
        bodies, graph = world.bodies, self.graph
        cars = np.arange(len(rows))[:, None]
        place = bodies.position[rows, :2]
        near = self.points[cars, self.at[:, None] + np.arange(6)]
        gaps = graph.place[near, :2] - place[:, None]
        self.at += (gaps * gaps).sum(axis=2).argmin(axis=1)
        for car in np.flatnonzero(self.at > RENEW_POINTS).tolist():
            at = int(self.at[car])
            self._write_row(car, int(self.points[car, at]), float(self.runs[car, at]))
        here = self.points[cars[:, 0], self.at]
        past = ((place - graph.place[here, :2]) * graph.ahead[here]).sum(axis=1)
        run = self.runs[cars[:, 0], self.at] + past
        yaw = np.radians(bodies.rotation[rows, 1])
        velocity = bodies.velocity[rows]
        speed = np.maximum(velocity[:, 0] * np.cos(yaw) + velocity[:, 1] * np.sin(yaw), 0.0)
        nose = bodies.center[rows, 0] + bodies.extent[rows, 0]
        window = self.at[:, None] + np.arange(self._sight_points(float(speed.max())))
        gap = self.runs[cars, window] - (run + nose)[:, None]
        index = np.array([actor.index for actor in actors])
        return TrafficView(rows, index, speed, run, nose, window, self.points[cars, window], gap)

    def _sight_points(self, fastest: float) -> int:
        """Return the number of lane points that the fastest car looks ahead; they are about a meter apart."""
        stopping = fastest * fastest / (2.0 * self.driver.braking_mps2)
        return min(AHEAD_POINTS, int(LEAST_SIGHT_M + fastest * self.driver.headway_s + stopping))

    def _accelerate(self, world: World, view: TrafficView) -> Floats:
        driver, speed = self.driver, view.speed
        reach = np.maximum(view.gap + view.nose[:, None], 0.0)
        targets = self.speeds[np.arange(len(speed))[:, None], view.window]
        wanted = np.sqrt((targets * targets + 2.0 * driver.braking_mps2 * reach).min(axis=1))
        wanted = np.minimum(wanted, SPEED_SHARE / 3.6 * world.fleet.limit_kmh[view.index])
        leader_gap, leader_speed = self._leaders(world.bodies, view)
        halt_gap = np.minimum(self._lights(world, view), self._signs(view))
        halt_gap = np.minimum(halt_gap, self._gates(view, halt_gap, leader_gap, leader_speed))
        # The bumper stops at a line, not at the standstill distance of the model before it.
        halt_gap = halt_gap + 0.7 * driver.standstill_m
        pull = np.minimum(
            interaction(driver, speed, leader_gap, leader_speed), interaction(driver, speed, halt_gap, 0.0 * speed)
        )
        return np.maximum(free_acceleration(driver, speed, wanted) + pull, -driver.emergency_mps2)

    def _leaders(self, bodies: BodyTable, view: TrafficView) -> tuple[Floats, Floats]:
        """Return the distance to the nearest body in each car's path (m), and its speed along it (m/s)."""
        body_row, point = blocked_points(self.graph.grid, self.graph.place, bodies)
        # If bodies share a point, at least one of the first and the last of them is not the car itself.
        item, other = (np.full(len(self.graph.place), -1) for _ in range(2))
        item[point], other[point[::-1]] = body_row, body_row[::-1]
        me = view.rows[:, None]
        first, second = item[view.points], other[view.points]
        body = np.where((first >= 0) & (first != me), first, np.where(second != me, second, -1))
        found, gap = _first((body >= 0) & (view.gap > -POINT_STEP_M), view.gap)
        cars = np.arange(len(found))
        ahead = self.graph.ahead[view.points[cars, found]]
        speed = (bodies.velocity[body[cars, found], :2] * ahead).sum(axis=1)
        return gap - 0.5 * POINT_STEP_M, np.where(np.isfinite(gap), np.maximum(speed, 0.0), 0.0)

    def _lights(self, world: World, view: TrafficView) -> Floats:
        """Return the distance to the stop line of a light that requires a stop (m)."""
        color = world.signals.lights.color
        if not len(color):
            return np.full(len(view.speed), np.inf)
        light = self.lines.light[view.points]
        shown = np.where(light >= 0, color[light], int(Color.GREEN))
        needed = (view.speed * view.speed)[:, None] / (2.0 * np.maximum(view.gap, 0.1))
        stop = (shown == Color.RED) & (needed < RED_MPS2) | (shown == Color.YELLOW) & (needed < AMBER_MPS2)
        return _first(stop & (view.gap > 0.0), view.gap)[1]

    def _signs(self, view: TrafficView) -> Floats:
        """Return the distance to a stop sign's line at which the car has not stopped yet (m)."""
        sign = self.lines.sign[view.points] > 0
        if not sign.any():
            return np.full(len(view.speed), np.inf)
        found, gap = _first(sign & (view.gap > 0.0) & (view.points != self.halted[:, None]), view.gap)
        halted = (gap < STOP_NEAR_M) & (view.speed < HALTED_MPS)
        self.halted = np.where(halted, view.points[np.arange(len(found)), found], self.halted)
        return np.where(halted, np.inf, gap)

    def _gates(self, view: TrafficView, halt_gap: Floats, leader_gap: Floats, leader_speed: Floats) -> Floats:
        """Return the distance to a junction that the car may not enter yet (m)."""
        front = view.run + view.nose
        for car in np.flatnonzero(view.run - view.nose > self.way_out).tolist():
            self.junctions.leave(car)
            self.way_out[car] = np.inf
            self._find_gate(car)
        gap = self.gate[:, 0] - front
        decide = view.speed * view.speed / (2.0 * self.driver.braking_mps2) + DECIDE_M
        room = (leader_gap > self.gate[:, 1] - front + 2.0 * view.nose + ROOM_M) | (leader_speed > ROLLING_MPS)
        asks = (gap < decide) & (halt_gap > gap) & room & ~np.isfinite(self.way_out)
        wishes = {car: self._lanes_at_gate(car) for car in np.flatnonzero(asks).tolist()}
        for car in self.junctions.grant(self.graph, wishes):
            self.way_out[car] = self.gate[car, 1]
            gap[car] = np.inf
            self._find_gate(car)
        return gap - BEFORE_GATE_M

    def _lanes_at_gate(self, car: int) -> tuple[int, ...]:
        return self.routes[car].next_junction(self.graph, float(self.gate[car, 0]) - 0.1)[2]

    def _control(self, world: World, view: TrafficView, acceleration: Floats) -> None:
        fleet = world.fleet
        speed, wanted, curvature = (np.zeros(len(fleet)) for _ in range(3))
        speed[view.index], wanted[view.index] = view.speed, acceleration
        curvature[view.index] = self._curvature(world, view)
        throttle, brake = fleet.pedals_for(wanted, speed)
        brake = np.where((speed < HALTED_MPS) & (wanted < 0.0), HOLD_BRAKE, brake)
        steer = fleet.steer_for(curvature, speed)
        control = fleet.control[view.index]
        control[:] = 0.0
        control[:, THROTTLE] = throttle[view.index]
        control[:, BRAKE] = brake[view.index]
        control[:, STEER] = steer[view.index]
        fleet.control[view.index] = control

    def _curvature(self, world: World, view: TrafficView) -> Floats:
        """Return the curvature of the arc from the rear axle to a point ahead on the lane (pure pursuit, 1/m)."""
        bodies = world.bodies
        look = np.clip(LOOK_S * view.speed, 0.0, MOST_LOOK_M) + LEAST_LOOK_M
        target = view.run + look
        cars = np.arange(len(target))
        window = self.at[:, None] + np.arange(int(MOST_LOOK_M + LEAST_LOOK_M) + 6)
        behind = (self.runs[cars[:, None], window] < target[:, None]).sum(axis=1).clip(1, window.shape[1] - 1)
        end = self.at + behind
        low, high = self.runs[cars, end - 1], self.runs[cars, end]
        share = np.clip((target - low) / np.maximum(high - low, 1e-3), 0.0, 1.0)[:, None]
        place = self.graph.place
        aim = place[self.points[cars, end - 1], :2] * (1.0 - share) + place[self.points[cars, end], :2] * share
        yaw = np.radians(bodies.rotation[view.rows, 1])
        cos, sin = np.cos(yaw), np.sin(yaw)
        half_base = 0.5 * world.fleet.wheelbase[view.index]
        gap = aim - bodies.position[view.rows, :2]
        ahead = gap[:, 0] * cos + gap[:, 1] * sin + half_base
        aside = gap[:, 1] * cos - gap[:, 0] * sin
        bend: Floats = 2.0 * aside / np.maximum(ahead * ahead + aside * aside, 1.0)
        return bend


def _first(which: NDArray[np.bool_], gap: Floats) -> tuple[Ints, Floats]:
    """Return the first point of each row that is marked, and the gap to it (infinite where none is)."""
    found = which.argmax(axis=1)
    cars = np.arange(len(which))
    return found, np.where(which[cars, found], gap[cars, found], np.inf)
