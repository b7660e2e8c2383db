"""Finds the lead vehicle of a car on its path, and checks whether two vehicles touch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.boxes import separation
from stucksolver_eval.actors.actor_pool import ActorState, ScenarioActor

if TYPE_CHECKING:
    from stucksolver_eval.actors.cars import Car

LOOK_POINTS = 24
"""Number of path points, 2 m apart, that are searched for a lead vehicle. Ours."""
_SIDE_M = 0.3
"""Lateral clearance below which an object blocks the path (m). Ours."""
_SAME_LEVEL_M = 4.0
"""Largest difference in height of objects on the same road (m). Ours."""

Array = NDArray[np.float64]


class Leader(NamedTuple):
    """The nearest object on a car's path: bumper gap (m), and its speed along the path (m/s)."""

    gap_m: float
    speed_mps: float

    def after(self, dt_s: float, own_mps: float) -> Leader:
        """Return the lead vehicle `dt_s` later, at constant speeds."""
        return Leader(self.gap_m + (self.speed_mps - own_mps) * dt_s, self.speed_mps)


def find_leaders(cars: Sequence[Car], bodies: Sequence[tuple[ScenarioActor, ActorState]]) -> None:
    """Set each car's `leader`. A body is approximated by circles along its length, as wide as the body."""
    circles, owner = _circles(bodies)
    for car in cars:
        car.leader = _leader(car, bodies, circles, owner)


def boxes_touch(actor: ScenarioActor, at: ActorState, other: ScenarioActor, there: ActorState, margin_m: float) -> bool:
    """Return True if two oriented boxes are at most `margin_m` apart."""
    first, second = ((*_middle(a, s), s.yaw_rad) for a, s in ((actor, at), (other, there)))
    halves = ((a.half_length_m, a.half_width_m) for a in (actor, other))
    return bool(separation(first, next(halves), second, next(halves)) <= margin_m)


def _middle(member: ScenarioActor, state: ActorState) -> tuple[float, float]:
    """Return the center of a body's box in CARLA's world frame (m)."""
    ahead, right = member.middle_m
    cos, sin = math.cos(state.yaw_rad), math.sin(state.yaw_rad)
    return state.x + ahead * cos - right * sin, state.y + ahead * sin + right * cos


def _circles(bodies: Sequence[tuple[ScenarioActor, ActorState]]) -> tuple[Array, NDArray[np.int64]]:
    """Return rows of x, y, z, radius (m), shape (n, 4), and the index of each row's body, shape (n,)."""
    rows: list[tuple[float, float, float, float]] = []
    owner: list[int] = []
    for index, (member, state) in enumerate(bodies):
        radius = min(member.half_width_m, member.half_length_m)
        reach = max(member.half_length_m, member.half_width_m) - radius
        # A prop may be wider than long.
        x, y = _middle(member, state)
        yaw = state.yaw_rad + (math.pi / 2 if member.half_width_m > member.half_length_m else 0.0)
        count = max(1, math.ceil(2.0 * reach / 2.5) + 1) if reach > 0.2 else 1
        for k in range(count):
            along = reach * (2.0 * k / (count - 1) - 1.0) if count > 1 else 0.0
            rows.append((x + along * math.cos(yaw), y + along * math.sin(yaw), state.z, radius))
            owner.append(index)
    return np.array(rows, dtype=np.float64).reshape(-1, 4), np.array(owner, dtype=np.int64)


def _leader(
    car: Car, bodies: Sequence[tuple[ScenarioActor, ActorState]], circles: Array, owner: NDArray[np.int64]
) -> Leader | None:
    path, first = car.path, car.path.at
    last = min(first + LOOK_POINTS, len(path.x))
    line = np.array([path.x[first:last], path.y[first:last]]).T
    s = np.array(path.s[first:last])
    reach = s[-1] - s[0] + 6.0
    near = (np.abs(circles[:, 0] - line[0, 0]) < reach) & (np.abs(circles[:, 1] - line[0, 1]) < reach)
    near &= np.abs(circles[:, 2] - car.state.z) < _SAME_LEVEL_M
    rows = np.flatnonzero(near)
    if not len(rows):
        return None
    apart = np.hypot(line[:, None, 0] - circles[None, rows, 0], line[:, None, 1] - circles[None, rows, 1])
    limit = circles[rows, 3] + car.member.half_width_m + _SIDE_M
    along = s[:, None] - np.sqrt(np.maximum(limit**2 - apart**2, 0.0))
    along = np.where(apart < limit, along, np.inf)
    front = car.s + car.member.half_length_m
    best, found = math.inf, -1
    for k in np.argsort(along.min(axis=0)).tolist():
        index = int(owner[rows[k]])
        at = float(along[:, k].min())
        if at == math.inf:
            break
        member, state = bodies[index]
        if member is car.member or car.state.ahead_m(state.x, state.y) < 0.0:
            continue
        best, found = at - front, index
        break
    if found < 0:
        return None
    state = bodies[found][1]
    yaw = path.yaw[min(first + int(np.argmin(np.abs(s - best - front))), len(path.yaw) - 1)]
    return Leader(max(best, 0.1), max(state.vx * math.cos(yaw) + state.vy * math.sin(yaw), 0.0))
