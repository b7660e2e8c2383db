"""Path of a behavior in road coordinates, in the form that the guard proves."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from stucksolver.scene.frenet import Array, Lane
from stucksolver.scene.frenet_scene import FrenetScene

STEP_M = 0.5
"""Distance between the stations of a path (m). Ours."""
SOFT_BRAKING_MPS2 = 1.0
"""Deceleration for which a path plans its stops and its lower speed limits (m/s²). Ours."""
LEAST_MPS = 0.3
"""Lower bound of the speed before a stop (m/s), so that the ego reaches the end of the path. Ours."""
HAND_BACK_BRAKING_MPS2 = 2.5
"""Hardest deceleration with which a stack is expected to brake for the end of a path (m/s²)."""


@dataclass(frozen=True)
class FrenetPath:
    """Path with stations every `STEP_M` along the road, lateral offsets, and upper bounds on the speed.

    A path in reverse is in the frame of `FrenetScene.backwards`.

    Attributes:
        s: (stations,): arc lengths (m).
        d: (stations,): lateral offsets (m, left positive).
        speed: (stations,): upper bounds on the speed (m/s).
        enters: Lanes that the path moves into or through, in order, without the lane in which it begins.
        passes: Ids of the objects that the path passes.
        returns: True if the path ends in the route's lane.
        over: Ids of the objects that the path drives over.
        stops: True if the path ends in a stop.
        yaw: Headings of the body relative to the road (rad), if they are known to differ from those of the path.
    """

    s: Array
    d: Array
    speed: Array
    enters: tuple[Lane, ...] = ()
    passes: tuple[str, ...] = ()
    returns: bool = True
    over: tuple[str, ...] = ()
    stops: bool = False
    yaw: Array | None = None

    @property
    def end_s(self) -> float:
        """Arc length of the path's end along the route (m)."""
        return float(self.s[-1])

    @property
    def end_d(self) -> float:
        """Lateral offset of the path's end from the route's lane (m, left positive)."""
        return float(self.d[-1])

    def heading(self) -> Array:
        """(stations,): heading of the path relative to the road (rad, left positive)."""
        if len(self.s) < 2:
            return np.zeros(len(self.s))
        d = np.concatenate([self.d[:1], self.d, self.d[-1:]])
        s = np.concatenate([self.s[:1], self.s, self.s[-1:]])
        heading: Array = np.arctan2(d[2:] - d[:-2], s[2:] - s[:-2])
        return heading

    def body(self, yaw_rad: float, wheelbase_m: float) -> Array:
        """(stations,): headings (rad) of a body that starts with `yaw_rad` and whose center follows the path."""
        return self.yaw if self.yaw is not None else body_heading(self.heading(), yaw_rad, wheelbase_m / 2)

    def from_station(self, s: float) -> FrenetPath:
        """Return the rest of the path from arc length `s` (m) to its end; at least its last two stations."""
        remaining = np.arange(max(s, float(self.s[0])), self.end_s - STEP_M / 2, STEP_M)
        stations: Array = np.append(remaining, self.end_s) if len(remaining) else self.s[-2:]
        d, speed = np.interp(stations, self.s, self.d), np.interp(stations, self.s, self.speed)
        return replace(self, s=stations, d=d, speed=speed, yaw=None)

    def then(self, other: FrenetPath) -> FrenetPath:
        """Return this path followed by another one that starts where this one ends."""
        return FrenetPath(
            np.concatenate([self.s, other.s[1:]]),
            np.concatenate([self.d, other.d[1:]]),
            np.concatenate([self.speed, other.speed[1:]]),
            self.enters + tuple(lane for lane in other.enters if lane not in self.enters),
            self.passes + tuple(p for p in other.passes if p not in self.passes),
            other.returns,
            self.over + tuple(p for p in other.over if p not in self.over),
            other.stops,
        )

    def stopping(self) -> FrenetPath:
        """Return the same path with a stop at its end."""
        remaining_m = np.maximum(self.end_s - self.s, 0.0)
        speed = np.minimum(self.speed, np.maximum(np.sqrt(2 * SOFT_BRAKING_MPS2 * remaining_m), LEAST_MPS))
        speed[-1] = 0.0
        return replace(self, speed=speed, stops=True)

    def within(self, speed_mps: float) -> FrenetPath:
        """Return the same path at no more than one speed (m/s)."""
        return replace(self, speed=np.minimum(self.speed, speed_mps))

    def no_quicker(self, limits_mps: Array) -> FrenetPath:
        """Return the same path within speed limits (stations,) (m/s); it brakes softly before a lower limit."""
        over = self.speed > limits_mps
        if not over.any():
            return self
        ramp = 2 * SOFT_BRAKING_MPS2 * self.s
        squared = np.where(over, np.square(limits_mps), np.inf) + ramp
        bound = np.sqrt(np.minimum.accumulate(squared[::-1])[::-1] - ramp)
        return replace(self, speed=np.minimum(self.speed, bound))


def body_heading(course_rad: Array, yaw_rad: float, lever_m: float) -> Array:
    """(stations,): headings (rad) of a body that starts with `yaw_rad` and whose center moves along `course_rad`.

    The rear axle, `lever_m` behind the center, does not slip sideways: dyaw/ds = sin(course - yaw) / lever. In a steady
    bend of radius R the slip is asin(lever / R), as for the kinematic bicycle; here for small angles.

    Args:
        course_rad: (stations,): directions, one every `STEP_M` (rad).
        yaw_rad: Heading at the start (rad).
        lever_m: Distance of the rear axle behind the center (m).
    """
    keeps = math.exp(-STEP_M / lever_m)
    headings = [yaw_rad]
    for course in course_rad[1:].tolist():
        headings.append(course + keeps * (headings[-1] - course))
    return np.array(headings)


def return_path(
    start: tuple[float, float], back_s: float, length_m: float, end_s: float, beside_mps: float, view: FrenetScene
) -> FrenetPath:
    """Return a path that keeps the offset of `start` until `back_s`, shifts back to the route, and ends at `end_s`.

    The shift is a cosine. `back_s` and the length may be any numbers; only the length of the whole path is rounded
    down to a multiple of `STEP_M`.

    Args:
        start: Arc length and offset (m).
        back_s: Arc length at which the shift begins (m).
        length_m: Length of the shift (m).
        end_s: Arc length of the end (m).
        beside_mps: Upper bound on the speed (m/s); lateral acceleration may bound it further during the shift.
        view: Surroundings in road coordinates.
    """
    s_from, d_from = start
    s: Array = s_from + STEP_M * np.arange(max(int((end_s - s_from) / STEP_M + 1e-6), 1) + 1)
    done = np.clip((s - back_s) / length_m, 0.0, 1.0)
    bound = lateral_shift_speed(d_from, length_m, view.ego.limits.max_lateral_acceleration_mps2)
    moves = (s > back_s - STEP_M) & (s < back_s + length_m + STEP_M)
    return FrenetPath(s, d_from * (1 + np.cos(np.pi * done)) / 2, np.where(moves, min(beside_mps, bound), beside_mps))


def landing_m(speed_mps: float) -> float:
    """Return the length of the straight that ends a path (m): the stack takes over before it brakes for the end."""
    return 2.0 + 0.5 * speed_mps + speed_mps**2 / (2 * HAND_BACK_BRAKING_MPS2)


def shift(d_from: float, d_to: float, length_m: float) -> Array:
    """(stations,): lateral offsets (m) of a shift along half a cosine wave, about every `STEP_M`, with both ends."""
    x = np.linspace(0.0, 1.0, max(round(length_m / STEP_M), 2) + 1)
    return d_from + (d_to - d_from) * (1 - np.cos(np.pi * x)) / 2


def lateral_shift_speed(lateral_m: float, length_m: float, max_lateral_mps2: float) -> float:
    """Return the highest speed at which a cosine shift stays within a lateral acceleration limit (m/s).

    The curvature of d(s) = D/2 (1 - cos(pi s/L)) is at most D/2 (pi/L)^2, reached at both ends.
    """
    curvature = abs(lateral_m) / 2 * (np.pi / length_m) ** 2
    return float(np.sqrt(max_lateral_mps2 / max(curvature, 1e-6)))


def shortest_shift(lateral_m: float, radius_m: float) -> float:
    """Return the length of the tightest cosine shift that a turning radius allows (m)."""
    return float(np.pi * np.sqrt(abs(lateral_m) * radius_m / 2))


def straight(s_from: float, d: float, length_m: float, speed_mps: float) -> FrenetPath:
    """Return a path at a constant lateral offset `d` (m)."""
    count = max(round(length_m / STEP_M), 1)
    s: Array = s_from + STEP_M * np.arange(count + 1)
    return FrenetPath(s, np.full(count + 1, d), np.full(count + 1, speed_mps))


def turned_shift(
    start: tuple[float, float], yaw_rad: float, d_to: float, length_m: float, speed_mps: float, view: FrenetScene
) -> FrenetPath | None:
    """Return the rest of a cosine shift for a vehicle in the middle of it, which already points toward `d_to`.

    A cosine shift of length L and height D has offset D/2 (1 - cos x) and slope pi D/(2 L) sin x at phase x. The rest
    of the height and the heading fix the phase, tan(x/2) = L tan(yaw) / (pi rest), and the height D.

    Args:
        start: Arc length and offset (m).
        yaw_rad: Heading relative to the road there, toward `d_to` (rad).
        d_to: Lateral offset at the end (m).
        length_m: Length of the whole shift (m); the rest is shorter.
        speed_mps: Upper bound on the speed (m/s); comfort bounds it as well.
        view: Surroundings in road coordinates.

    Returns:
        Path; None if the vehicle cannot turn back that tightly.
    """
    rest_m = d_to - start[1]
    phase = 2.0 * math.atan(length_m * math.tan(yaw_rad) / (math.pi * rest_m))
    whole_m = 2.0 * rest_m / (1.0 + math.cos(phase))
    if length_m < shortest_shift(whole_m, view.ego.limits.min_turn_radius_m):
        return None
    count = max(round(length_m * (1.0 - phase / math.pi) / STEP_M), 2)
    phases: Array = np.linspace(phase, math.pi, count + 1)
    offsets = d_to - whole_m * (1.0 + np.cos(phases)) / 2
    bound = lateral_shift_speed(whole_m, length_m, view.ego.limits.max_lateral_acceleration_mps2)
    s: Array = start[0] + STEP_M * np.arange(count + 1)
    return FrenetPath(s, offsets, np.full(count + 1, min(speed_mps, bound)))


FADE_M = 10.0
"""Distance over which a path moves to the center of its lane (m). Ours."""


def along_lane(lane: Lane | None, s_from: float, d_from: float, length_m: float, speed_mps: float) -> FrenetPath:
    """Return a path along the center of a lane, reached within `FADE_M`; at a constant offset without a lane."""
    path = straight(s_from, d_from, length_m, speed_mps)
    if lane is None:
        return path
    center = np.interp(path.s, lane.s, lane.center)
    fade = np.clip(1.0 - (path.s - s_from) / FADE_M, 0.0, 1.0)
    return FrenetPath(path.s, center + fade**2 * (d_from - center[0]), path.speed)


def lateral(
    s_from: float, d_from: float, d_to: float, length_m: float, speed_mps: float, view: FrenetScene
) -> FrenetPath:
    """Return a lateral shift, slowed down to the vehicle's limit of lateral acceleration."""
    offsets = shift(d_from, d_to, length_m)
    bound = lateral_shift_speed(d_to - d_from, length_m, view.ego.limits.max_lateral_acceleration_mps2)
    s: Array = s_from + STEP_M * np.arange(len(offsets))
    return FrenetPath(s, offsets, np.full(len(offsets), min(speed_mps, bound)))
