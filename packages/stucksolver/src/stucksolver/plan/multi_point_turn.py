"""Geometry of a turn in several legs: forward on left lock, back on right lock, until the vehicle faces back.

The vehicle is modeled as a bicycle whose rear axle does not slip sideways. It drives on circles whose radius its
steering allows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stucksolver.plan.behaviors.behavior import NoPathError
from stucksolver.plan.frenet_path import LEAST_MPS, SOFT_BRAKING_MPS2
from stucksolver.scene.boxes import separation
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import MOVING_MPS, FrenetScene

POSE_STEP_M = 0.1
"""Travel of the rear axle between poses (m): the gap that counts as contact (`HarmPolicy.touch_m`)."""
RADIUS_PART = 1.05
"""Ratio of the planned radius to the smallest one of the vehicle, as a reserve for steering. Ours."""
LOCK_M = 1.0
"""Distance over which the wheels turn from straight to full lock (m), starting at rest. Ours."""
EDGE_M = 0.3
"""Planned distance from the edges of the road (m): the guard's gap to stationary objects."""
THING_M, LIVING_M = 0.6, 1.5
"""Planned distance from stationary objects, and from vulnerable road users (m).

Both exceed the guard's bounds of 0.3 m and 1 m, as a reserve for errors. Ours.
"""
POINT_EVERY = 3
"""Number of poses for each point of the line that a stack drives. Ours."""
CRAWL_MPS = 0.05
"""Speed beyond the end of a leg (m/s): almost zero, since stacks reject a line that they would never finish."""
LEAST_LEG_M = 0.5
"""Least length of a leg (m): a shorter one does not help. Ours."""
MOST_LEGS = 5
"""Greatest number of legs. If more are needed, the road counts as too narrow. Ours."""
TURNED_RAD = math.radians(165.0)
"""Heading change after which the turn is done (rad). The ego drives off in the other lane and straightens. Ours."""


@dataclass(frozen=True)
class Leg:
    """Leg of the turn, from stop to stop.

    `x_m`, `y_m`, `yaw_rad` (poses,): the body's center and heading in the local frame, every `POSE_STEP_M` of travel.
    """

    reverse: bool
    x_m: Array
    y_m: Array
    yaw_rad: Array

    @property
    def length_m(self) -> float:
        """Travel of the rear axle (m)."""
        return POSE_STEP_M * (len(self.x_m) - 1)

    @property
    def end(self) -> tuple[float, float, float]:
        """(x, y, heading) at the end of the leg (m, m, rad)."""
        return float(self.x_m[-1]), float(self.y_m[-1]), float(self.yaw_rad[-1])


def leg_driving_line(leg: Leg, wheelbase_m: float, speed_mps: float) -> tuple[Array, Array, Array]:
    """Return x, y (m) and speed (m/s), each (points,), of the line that a stack drives to stop at the leg's end.

    A line forward is that of the body's center. A line in reverse is that of the rear axle, which then leads. It
    continues at a crawl beyond the final position of the center, where the stack brakes.
    """
    lever_m = wheelbase_m / 2
    travel = POSE_STEP_M * np.arange(len(leg.x_m))
    x, y = leg.x_m, leg.y_m
    if leg.reverse:
        x, y = x - lever_m * np.cos(leg.yaw_rad), y - lever_m * np.sin(leg.yaw_rad)
        x, y = np.concatenate([leg.x_m[:1], x]), np.concatenate([leg.y_m[:1], y])
        travel = np.concatenate([[0.0], travel + lever_m])
    room = np.maximum(leg.length_m - travel, 0.0)
    speed = np.minimum(speed_mps, np.maximum(np.sqrt(2 * SOFT_BRAKING_MPS2 * room), LEAST_MPS))
    speed[travel >= leg.length_m - POSE_STEP_M / 2] = CRAWL_MPS
    keep = np.zeros(len(x), dtype=bool)
    keep[::POINT_EVERY] = keep[int(np.argmax(speed == CRAWL_MPS))] = keep[-1] = True
    speed[-1] = 0.0
    return x[keep], y[keep], speed[keep]


def heading_change_rad(view: FrenetScene) -> float:
    """Return the angle by which the ego has turned left from the road's direction, in [-pi/2, 3 pi/2) (rad)."""
    return (view.ego_yaw + math.pi / 2) % math.tau - math.pi / 2


def multi_point_turn(view: FrenetScene) -> tuple[Leg, ...]:
    """Return the legs until the ego faces the other way, each as long as the road allows.

    The turn begins forward if there is room, otherwise by backing up.

    Raises:
        NoPathError: The road is too narrow.
    """
    heading = float(np.interp(view.ego_s, view.frame.s, view.frame.headings))
    pose = (view.ego.x_m, view.ego.y_m, heading + heading_change_rad(view))
    until = heading + math.pi
    legs: list[Leg] = []
    reverse, skipped = False, False
    while pose[2] - heading < TURNED_RAD:
        leg = _leg(view, pose, until, reverse)
        reverse = not reverse
        if leg.length_m < LEAST_LEG_M:
            if skipped or len(legs) > 0:
                raise NoPathError(
                    PlanFailure.NO_ROOM_TO_TURN,
                    f"road too narrow to turn around: leg of {leg.length_m:.1f} m, required {LEAST_LEG_M:g} m",
                )
            skipped = True
            continue
        legs.append(leg)
        pose = leg.end
        if len(legs) > MOST_LEGS:
            raise NoPathError(
                PlanFailure.NO_ROOM_TO_TURN, f"road too narrow to turn around in at most {MOST_LEGS} legs"
            )
    return tuple(legs)


def _leg(view: FrenetScene, pose: tuple[float, float, float], until_rad: float, reverse: bool) -> Leg:
    """Return the leg that ends where the space ends, or where the body's heading reaches `until_rad`."""
    x, y, yaw = _poses(view, pose, reverse)
    fits = _on_the_road(view, x, y, yaw) & _clear(view, x, y, yaw) & (yaw <= until_rad + 1e-6)
    fits[0] = True  # The present pose always fits.
    count = len(fits) if fits.all() else int(fits.argmin())
    return Leg(reverse, x[:count], y[:count], yaw[:count])


def _poses(view: FrenetScene, pose: tuple[float, float, float], reverse: bool) -> tuple[Array, Array, Array]:
    """Return x, y (m) and heading (rad), each (poses,), for half a circle to the left from straight wheels."""
    lever_m = view.ego.limits.wheelbase_m / 2
    radius_m = RADIUS_PART * view.ego.limits.min_turn_radius_m
    travel = np.arange(0.0, math.pi * radius_m, POSE_STEP_M)
    bend = np.minimum(travel / LOCK_M, 1.0) / radius_m
    yaw: Array = pose[2] + np.concatenate([[0.0], np.cumsum(bend[1:] * POSE_STEP_M)])
    sign = -1.0 if reverse else 1.0
    middle = (yaw[1:] + yaw[:-1]) / 2
    rear_x = (
        pose[0] - lever_m * math.cos(pose[2]) + np.concatenate([[0.0], np.cumsum(sign * POSE_STEP_M * np.cos(middle))])
    )
    rear_y = (
        pose[1] - lever_m * math.sin(pose[2]) + np.concatenate([[0.0], np.cumsum(sign * POSE_STEP_M * np.sin(middle))])
    )
    return rear_x + lever_m * np.cos(yaw), rear_y + lever_m * np.sin(yaw), yaw


def corners(view: FrenetScene, x_m: Array, y_m: Array, yaw_rad: Array) -> tuple[Array, Array]:
    """Return arc lengths and offsets of the body's corners along the road (m), each (poses, 4), for poses (poses,)."""
    half_length, half_width = view.ego.length_m / 2, view.ego.width_m / 2
    ahead, left = np.array([1.0, 1.0, -1.0, -1.0]) * half_length, np.array([1.0, -1.0, 1.0, -1.0]) * half_width
    cos, sin = np.cos(yaw_rad)[:, None], np.sin(yaw_rad)[:, None]
    places = np.stack([x_m[:, None] + ahead * cos - left * sin, y_m[:, None] + ahead * sin + left * cos], axis=-1)
    s, d, _ = view.frame.to_road(places.reshape(-1, 2))
    return s.reshape(-1, 4), d.reshape(-1, 4)


def room_at_edges_m(view: FrenetScene, x_m: Array, y_m: Array, yaw_rad: Array) -> Array:
    """(poses,): smallest distance of a corner from the edges of the driving lanes (m); negative beyond them."""
    s, d = corners(view, x_m, y_m, yaw_rad)
    low, high = (np.interp(s, view.frame.s, border) for border in view.frame.drivable)
    result: Array = np.minimum(d - low, high - d).min(axis=1)
    return result


def _on_the_road(view: FrenetScene, x: Array, y: Array, yaw: Array) -> Array:
    room = room_at_edges_m(view, x, y, yaw)
    # A vehicle that is already nearer to an edge may move away from it, but must not come nearer.
    result: Array = room > np.minimum(EDGE_M, room[0] - 1e-3)
    return result


def gaps_m(view: FrenetScene, which: Array, x_m: Array, y_m: Array, yaw_rad: Array) -> Array:
    """(poses, objects): gaps from the body at the poses, each (poses,), to the present boxes of the objects (m)."""
    objects = [view.objects[int(i)] for i in which]
    x, y, yaw = (np.array([getattr(o, name) for o in objects]) for name in ("x_m", "y_m", "yaw_rad"))
    result: Array = separation(
        (x_m[:, None], y_m[:, None], yaw_rad[:, None]),
        (view.ego.length_m / 2, view.ego.width_m / 2),
        (x, y, yaw),
        (view.half_length[which], view.half_width[which]),
    )
    return result


def _clear(view: FrenetScene, x: Array, y: Array, yaw: Array) -> Array:
    standing = np.flatnonzero(view.speed <= MOVING_MPS)
    if not len(standing):
        return np.ones(len(x), dtype=bool)
    gap = gaps_m(view, standing, x, y, yaw)
    required_m = np.where(view.vulnerable[standing], LIVING_M, THING_M)
    result: Array = (gap > np.minimum(required_m, gap[0] - 1e-3)).all(axis=1)
    return result
