"""Proven paths in the form that a stack drives."""

from __future__ import annotations

import numpy as np

from stucksolver.guard import Guard, ProvenLeg, ProvenPlan
from stucksolver.plan import Execute, PathPoint
from stucksolver.plan.behaviors import Behavior, KeepLane
from stucksolver.plan.frenet_path import FrenetPath, landing_m
from stucksolver.plan.multi_point_turn import leg_driving_line
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution_steps import stand
from stucksolver.solver.state_machine.gap_wait import STOPPED_MPS

ARRIVED_M = 1.5
"""A behavior counts as driven at this distance before its end; a whole path at the distance that `landing_m` gives."""
SHORT_M = 5.0
"""A path up to this long is driven in a creep for its own sake and counts as driven when a quarter is left."""


def along_leg(proven: ProvenLeg, view: FrenetScene) -> Execute:
    """Return the rest of a leg of a turn as a directive: the line of the rear axle in the local frame."""
    x, y, speed = leg_driving_line(proven.rest(view), view.ego.limits.wheelbase_m, proven.behavior.speed_mps)
    rows = np.stack([x, y, speed], axis=1).round(3).tolist()
    path = tuple(PathPoint(x_m=a, y_m=b, speed_mps=v) for a, b, v in rows)
    return Execute(behavior=proven.behavior, path=path, reverse=proven.reverse)


def along_path(proven: ProvenPlan, view: FrenetScene, behavior: Behavior, *, over_red: bool) -> Execute:
    """Return the rest of a proven path as a directive. `over_red`: an operator has approved a red light on it."""
    turned = facing(view, proven)
    rest = proven.path.from_station(turned.ego_s)
    path = path_points(rest, turned, np.array([proven.committed(float(s)) for s in rest.s]))
    return Execute(behavior=behavior, path=path, reverse=proven.reverse, ignore=proven.path.over, over_red=over_red)


def along_way_back(way_back: FrenetPath, view: FrenetScene) -> Execute:
    """Return a way back into the lane as a directive."""
    distance = min(max(way_back.end_s - view.ego_s, 5.0), 150.0)
    behavior = KeepLane(distance_m=distance, speed_mps=min(max(view.ego.speed_mps, 3.0), 11.0))
    return Execute(behavior=behavior, path=path_points(way_back, view, no_stop=True))


def blind_stop(guard: Guard, path: FrenetPath, view: FrenetScene, behavior: Behavior, reverse: bool) -> Execute:
    """Return a slow stop on a path. Compute it once: what is known does not change until perception works again."""
    way = guard.stopping_soon(path, view, reverse)
    if way is None:
        return stand(None)
    points = path_points(way, view.backwards if reverse else view, no_stop=True)
    return Execute(behavior=behavior, path=points, reverse=reverse)


def facing(view: FrenetScene, proven: ProvenPlan) -> FrenetScene:
    """Return the view in the direction of a plan: backwards if it backs up."""
    return view.backwards if proven.reverse else view


def path_points(path: FrenetPath, view: FrenetScene, no_stop: Array | bool = False) -> tuple[PathPoint, ...]:
    """Return a path in the local frame. `no_stop` marks the points where finishing is safe and stopping is not."""
    x, y, _ = view.frame.to_local(path.s, path.d)
    rows = np.stack([x, y, path.speed], axis=1).round(3).tolist()
    bound = np.broadcast_to(no_stop, len(rows)).tolist()
    return tuple(PathPoint(x_m=a, y_m=b, speed_mps=v, no_stop=c) for (a, b, v), c in zip(rows, bound, strict=True))


def has_arrived(proven: ProvenPlan, seen: FrenetScene) -> bool:
    """Return True if a path counts as driven; `seen` faces in its direction."""
    left, way = proven.path.end_s - seen.ego_s, proven.path.end_s - float(proven.path.s[0])
    if proven.path.stops:
        return left < min(ARRIVED_M, way / 2) and abs(seen.ego.speed_mps) < STOPPED_MPS
    return left <= (landing_m(seen.ego.speed_mps) if way > SHORT_M else way / 4)
