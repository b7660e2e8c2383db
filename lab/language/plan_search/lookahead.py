"""A quick look-ahead: the world is rebuilt once from the surroundings, and forked for each plan and hypothesis.

It only ranks plans. The forks do not run the scenario's scripts, so a plan gets its grade only from an exact drive.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from carlette.blueprints import load_catalog
from carlette.geometry import Box
from carlette.in_process import Pose, Rotation, SpawnCollisionError, Traffic, Vector, World, open_world, spawn
from carlette.world.actor import Actor, ActorKind
from lab.language.plan_search.ego_trajectory import EgoTrajectory
from stucksolver.scene import Surroundings
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet import Array, road_frame
from stucksolver.scene.objects import TWO_WHEELED, VEHICLES, TrackedObject

HORIZON_S = 25.0
"""Length of the look-ahead (s). A pass takes about 15 s; the rest shows whether the ego makes progress after it."""
TICK_S = 0.1
"""Step of the look-ahead (s).

It is twice the step of the drives: half the work, and still 1 m at the highest speed of a plan.
"""
EGO = "vehicle.lincoln.mkz_2020"
NEAR_M = 0.3
"""Gap of a near miss (m)."""
NEARER_M = 0.05
"""Approach from which a road user counts (m). Ours.

A road user that has not come nearer by this much was already there. It counts neither as a contact nor as a near miss.
"""
CONTACT_COSTS_M, NEAR_COSTS_M = 200.0, 20.0
"""Meters of progress that a contact and a near miss outweigh. Ours: they only order a list."""
MOST_PROGRESS_M = 60.0
"""Largest progress that counts (m). Ours."""
CLEARANCE_M = 0.1
"""Clearance of bodies in the rebuilt world (m). Ours."""


class Hypothesis(str, Enum):
    """Assumed motion of the other road users."""

    STAND = "stand"
    """All stay at their positions."""
    ROLL = "roll"
    """Road users ahead keep their velocity. Stationary ones and those behind stay at their positions."""
    DRIVE = "drive"
    """All vehicles, including stationary ones, drive along their lanes, controlled by carlette's own traffic."""


@dataclass
class LookAheadCost:
    """The work done so far."""

    forks: int = 0
    """Number of forks."""
    seconds: float = 0.0
    """Wall time (s)."""


@dataclass
class LookAhead:
    """Ranks trajectories from one standstill.

    Args:
        town: Name of the map, whose frame the surroundings use.
        surroundings: The surroundings at this tick.
        maps: Additional folders of maps.
    """

    town: str
    surroundings: Surroundings
    maps: Sequence[str] = ()
    spent: LookAheadCost = field(default_factory=LookAheadCost)

    def __post_init__(self) -> None:
        self._world = open_world(self.town, self.maps)
        self._world.settings = type(self._world.settings)(fixed_delta_s=TICK_S)
        ego = self.surroundings.ego
        self._ego = _vehicle(self._world, EGO, ego.x_m, ego.y_m, ego.yaw_rad)
        self._frame = road_frame(self.surroundings.road)
        self._others: list[tuple[Actor, TrackedObject]] = []
        for obj in self.surroundings.objects:
            actor = _enter(self._world, obj)
            if actor is not None:
                self._others.append((actor, obj))
        self._half = (
            np.array([o.length_m / 2 for _, o in self._others]),
            np.array([o.width_m / 2 for _, o in self._others]),
        )
        self._first_m = self._gaps(self._world)

    def value(self, trail: EgoTrajectory) -> float:
        """Return the progress minus the cost of contacts and near misses (m), averaged over all hypotheses."""
        return float(np.mean([self.outcome(trail, hypothesi) for hypothesi in Hypothesis]))

    def outcome(self, trail: EgoTrajectory, hypothesis: Hypothesis) -> float:
        """Return the value under one hypothesis.

        After the trajectory, carlette's traffic drives the ego along its lane.
        """
        began = time.perf_counter()
        world = self._world.fork()
        self.spent.forks += 1
        driven = [a.id for a, o in self._others if o.kind in VEHICLES] if hypothesis is Hypothesis.DRIVE else []
        world.traffic = Traffic(world, driven) if driven else None
        if hypothesis is not Hypothesis.DRIVE:
            # Stop bodies without a driver. They would keep rolling.
            world.bodies.velocity[[world.actors[actor.id].row for actor, _ in self._others]] = 0.0
        least_m, on_its_own = math.inf, False
        for tick in range(1, round(HORIZON_S / TICK_S) + 1):
            t_s = tick * TICK_S
            if hypothesis is Hypothesis.ROLL:
                self._roll(world, t_s)
            if t_s > trail.end_s and not on_its_own:
                on_its_own = True
                world.traffic = Traffic(world, [*driven, self._ego.id])
            world.tick()
            if t_s <= trail.end_s:
                # After the tick: its physics must not move a body that follows a trajectory.
                _put(world, self._ego, trail, t_s)
                # After the trajectory, the outcome depends on the traffic and not on the plan, so only the
                # progress counts.
                least_m = min(least_m, self._gap(world))
            if least_m <= 0.0:
                break
        self.spent.seconds += time.perf_counter() - began
        cost = CONTACT_COSTS_M if least_m <= 0.0 else NEAR_COSTS_M * (least_m < NEAR_M)
        return min(self._progress(world), MOST_PROGRESS_M) - cost

    def _roll(self, world: World, t_s: float) -> None:
        ego = self.surroundings.ego
        for actor, other in self._others:
            beyond = (other.x_m - ego.x_m) * math.cos(ego.yaw_rad) + (other.y_m - ego.y_m) * math.sin(ego.yaw_rad)
            if beyond < 0.0:
                # Traffic behind would brake for a stationary vehicle.
                continue
            position = world.bodies.position[world.actors[actor.id].row]
            start = self._world.bodies.position[actor.row]
            position[:2] = start[0] + other.vx_mps * t_s, start[1] - other.vy_mps * t_s

    def _gap(self, world: World) -> float:
        """Return the smallest gap to a road user that is nearer than at the standstill (m)."""
        gaps = self._gaps(world)
        return float(gaps[gaps < self._first_m - NEARER_M].min(initial=math.inf))

    def _gaps(self, world: World) -> Array:
        """Return the gap to each of the others (others,) (m)."""
        bodies, ego = world.bodies, world.actors[self._ego.id].row
        rows = [world.actors[actor.id].row for actor, _ in self._others]
        mine = *bodies.position[ego, :2].tolist(), math.radians(bodies.rotation[ego, 1])
        theirs = bodies.position[rows, 0], bodies.position[rows, 1], np.radians(bodies.rotation[rows, 1])
        half = self.surroundings.ego.length_m / 2, self.surroundings.ego.width_m / 2
        return separation(mine, half, theirs, self._half)

    def _progress(self, world: World) -> float:
        """Return the distance traveled along the route since the standstill (m)."""
        x, y = world.bodies.position[world.actors[self._ego.id].row, :2].tolist()
        points = np.array([[self.surroundings.ego.x_m, self.surroundings.ego.y_m], [x, -y]])
        s, _, _ = self._frame.to_road(points)
        return float(s[1] - s[0])


def _put(world: World, ego: Actor, trail: EgoTrajectory, t_s: float) -> None:
    """Place the ego on its trajectory, with the velocity that leads to the next pose."""
    (x, y, yaw), (x1, y1, _) = trail.pose_at(t_s), trail.pose_at(t_s + TICK_S)
    row = world.actors[ego.id].row
    world.bodies.position[row, :2] = x, -y
    world.bodies.rotation[row, 1] = -math.degrees(yaw)
    ahead = (trail.speed_mps * math.cos(yaw), trail.speed_mps * math.sin(yaw))
    velocity = ((x1 - x) / TICK_S, (y1 - y) / TICK_S) if t_s + TICK_S <= trail.end_s else ahead
    world.bodies.velocity[row, :2] = velocity[0], -velocity[1]


def _enter(world: World, object: TrackedObject) -> Actor | None:
    """Add an object to the world: a vehicle as the model nearest in size, anything else as a box that does not move."""
    if object.kind in VEHICLES:
        two_wheeled = object.kind in TWO_WHEELED
        models = [m for m in load_catalog().vehicles.values() if m.is_two_wheeler is two_wheeled]
        size = (object.length_m / 2, object.width_m / 2)
        fit = min(models, key=lambda m: abs(m.box.extent.x - size[0]) + abs(m.box.extent.y - size[1]))
        try:
            actor = _vehicle(world, fit.id, object.x_m, object.y_m, object.yaw_rad)
        except SpawnCollisionError:
            # Two objects may overlap in the perceived surroundings. The second one is left out.
            return None
        world.bodies.velocity[actor.row, :2] = object.vx_mps, -object.vy_mps
        return actor
    half = Vector(object.length_m / 2, object.width_m / 2, object.height_m / 2)
    pose = _pose(world, object.x_m, object.y_m, object.yaw_rad)
    actor = world.enter("static.prop.box", ActorKind.OTHER, pose, Box(Vector(z=half.z), half))
    world.bodies.solid[actor.row] = True
    return actor


def _vehicle(world: World, model: str, x_m: float, y_m: float, yaw_rad: float) -> Actor:
    return spawn(world, model, {}, _pose(world, x_m, y_m, yaw_rad))


def _pose(world: World, x_m: float, y_m: float, yaw_rad: float) -> Pose:
    """Return a pose on the ground in CARLA's frame, for a position in the map's right-handed frame (m, m, rad)."""
    place = Vector(x_m, -y_m, 0.0)
    height = world.roads.ground(place).origin.z + CLEARANCE_M
    return Pose(Vector(x_m, -y_m, height), Rotation(yaw=-math.degrees(yaw_rad)))
