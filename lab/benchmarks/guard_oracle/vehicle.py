"""The oracle's ego: a kinematic bicycle without slip at the rear axle, and a path follower that only obeys directives.

There is no emergency braking: the ego only brakes when a directive says so. With `follows` it keeps its distance to a
lead vehicle in its direction, as `docs/SAFETY.md` assumes of a stack, with comfortable braking only.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, field, replace

import numpy as np

from lab.benchmarks.guard_oracle.bodies import Body
from stucksolver.plan import Directive, Execute

LENGTH_M = 4.9
"""Length (m)."""
WIDTH_M = 1.85
"""Width (m)."""
WHEELBASE_M = 2.9
"""Wheelbase (m)."""
RADIUS_M = 6.0
"""Turning radius (m)."""
ACCELERATES_MPS2 = 1.5
"""Acceleration (m/s²)."""
BRAKES_MPS2 = 3.0
"""Comfortable deceleration (m/s²)."""
STATED_LAG_S = 0.3
"""Delay of the brakes that the vehicle states (s), as in assumption A9; `Manner.lag` is at most this."""
LOCK_RAD = math.atan(WHEELBASE_M / RADIUS_M)
STEERS_RADPS = 0.6
"""Rate of the front wheels (rad/s): about one and a half turns of a steering wheel per second."""
REACH_M, APPROACH_RAD = 2.0, 0.4
"""Distance over which the follower returns to its path (m), and the largest angle of the return (rad)."""


@dataclass(frozen=True)
class Manner:
    """Accuracy and speed with which the vehicle obeys.

    `eager`, `keen` in [0, 1]: shares of its acceleration and of the allowed speed. `lag`: time from a directive to
    brake until the brakes act (s). `drift`: final offset from its path (m, left positive), which grows from
    `drifts_from` (s) on, at `drift_rate` (m/s). `follows`: it keeps its distance to a lead vehicle.
    """

    eager: float = 1.0
    """Share of its acceleration."""
    keen: float = 1.0
    """Share of the allowed speed."""
    lag: float = 0.0
    """Delay of the brakes (s)."""
    drift: float = 0.0
    """Final offset from its path (m, left positive)."""
    drift_rate: float = 0.1
    """Growth of the offset (m/s)."""
    drifts_from: float = 0.0
    """Time from which the offset grows (s)."""
    follows: bool = False

    def drift_at(self, t: float) -> float:
        """Return the offset from the path that the drift has reached by the time `t` (m)."""
        grown = max(t - self.drifts_from, 0.0) * self.drift_rate
        return math.copysign(min(grown, abs(self.drift)), self.drift)


@dataclass
class Track:
    """A directive's path as arrays: points (m), their arc lengths from the first, bounds on the speed (m/s)."""

    x: np.ndarray
    y: np.ndarray
    s: np.ndarray
    speed: np.ndarray
    at: float = 0.0
    """Position of the vehicle along the path (m)."""

    def __post_init__(self) -> None:
        # Lists are far quicker than arrays here: single points are read on every tick.
        self._points = list(zip(self.x.tolist(), self.y.tolist(), self.s.tolist(), strict=True))

    @staticmethod
    def from_order(order: Execute) -> Track:
        """Return the path of a directive."""
        x = np.array([p.x_m for p in order.path])
        y = np.array([p.y_m for p in order.path])
        s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        return Track(x, y, s, np.array([p.speed_mps for p in order.path]))

    @property
    def end(self) -> float:
        return float(self.s[-1])

    def advance(self, x: float, y: float) -> tuple[float, float, float]:
        """Return (offset to the left of the path, its direction, its curvature) at the point's projection onto it."""
        near = np.flatnonzero((self.s >= self.at - 1.0) & (self.s <= self.at + 3.0))
        points, final = self._points, len(self._points) - 2
        first, last = (min(int(near[0]), final), min(int(near[-1]), final)) if len(near) else (final, final)
        best = (math.inf, 0.0, 0.0, 0.0, 0)
        for k in range(first, last + 1):
            (from_x, from_y, from_s), (to_x, to_y, _) = points[k], points[k + 1]
            dx, dy = to_x - from_x, to_y - from_y
            length = max(math.hypot(dx, dy), 1e-9)
            along = ((x - from_x) * dx + (y - from_y) * dy) / length
            offset = (dx * (y - from_y) - dy * (x - from_x)) / length
            low = -math.inf if k == 0 else 0.0
            high = math.inf if k == final else length
            out = along - min(max(along, low), high)
            if math.hypot(out, offset) < best[0]:
                place = from_s + min(max(along, low), high)
                best = (math.hypot(out, offset), place, offset, math.atan2(dy, dx), k)
        self.at = max(best[1], self.at - 0.5)
        k = best[4]
        after = self._direction(min(k + 2, final))
        before = self._direction(max(k - 1, 0))
        span = 0.5 * (min(k + 2, final) - max(k - 1, 0)) or 1.0
        return best[2], best[3], wrapped(after - before) / span

    def _direction(self, k: int) -> float:
        (from_x, from_y, _), (to_x, to_y, _) = self._points[k], self._points[k + 1]
        return math.atan2(to_y - from_y, to_x - from_x)

    def allowed(self, share: float) -> float:
        """Return the highest speed from which comfortable braking keeps every bound ahead."""
        room = self.s - self.at
        ahead = room > -0.5
        if not ahead.any():
            return share * float(self.speed[-1])
        squares = (share * self.speed[ahead]) ** 2 + 2 * BRAKES_MPS2 * np.maximum(room[ahead], 0.0)
        return math.sqrt(float(squares.min()))


def wrapped(angle: float) -> float:
    """Wrap an angle to [-pi, pi]."""
    return math.remainder(angle, math.tau)


@dataclass
class Ego:
    """The vehicle: pose of its body's center, speed (negative in reverse), and the angle of its front wheels."""

    x: float
    y: float
    yaw: float
    speed: float
    manner: Manner
    steer: float = 0.0
    """Angle of the front wheels (rad)."""
    _track: Track | None = None
    _order: Execute | None = None
    _braking_for: float = field(default=0.0)
    """Time for which the vehicle has been ordered to brake (s)."""

    def body(self) -> Body:
        return Body(self.x, self.y, self.yaw, LENGTH_M, WIDTH_M)

    def copied(self) -> Ego:
        """Return a copy that can be driven on without a change to this one."""
        return replace(self, _track=copy.copy(self._track))

    @property
    def path_is_done(self) -> bool:
        return self._track is None or self._track.at >= self._track.end - 0.1

    def obey(self, order: Directive, t: float, dt: float, room: float = math.inf, ahead: float = 0.0) -> None:
        """Execute a directive for one step of `dt` seconds.

        `room`, `ahead`: gap to the lead vehicle (m), and its speed (m/s).
        """
        if isinstance(order, Execute) and order.path:
            if order is not self._order:
                self._order, self._track = order, Track.from_order(order)
            self._braking_for = 0.0
            self._drive(order, t, dt, room, ahead)
            return
        self._braking_for += dt
        hard = order.brake_mps2 if isinstance(order, Execute) and hasattr(order, "brake_mps2") else None
        slower = (hard or BRAKES_MPS2) * dt if self._braking_for > self.manner.lag else 0.0
        self._set(math.copysign(max(abs(self.speed) - slower, 0.0), self.speed), dt)
        self._steer(t, dt)

    def _drive(self, order: Execute, t: float, dt: float, room: float, ahead: float) -> None:
        assert self._track is not None
        if order.reverse:
            left = self._track.end - self._track.at
            most = min(self._track.allowed(1.0), math.sqrt(2 * max(left - 0.05, 0.0)))
            self._set(-min(most, abs(self.speed) + 1.0 * dt), dt)
            self._steer(t, dt)
            return
        manner = self.manner
        most = self._track.allowed(0.85 + 0.15 * manner.keen)
        if manner.follows:
            most = min(most, math.sqrt(max(ahead, 0.0) ** 2 + 2 * BRAKES_MPS2 * max(room - 1.5, 0.0)))
        quicker = self.speed + (0.6 + 0.4 * manner.eager) * ACCELERATES_MPS2 * dt
        self._set(max(min(quicker, most), self.speed - BRAKES_MPS2 * dt, 0.0), dt)
        self._steer(t, dt)

    def _set(self, speed: float, dt: float) -> None:
        """Move with the mean speed of a step; the rear axle moves in the direction of the heading."""
        way = (self.speed + speed) / 2 * dt
        self.speed = speed
        lever = WHEELBASE_M / 2
        bend = math.tan(self.steer) / WHEELBASE_M
        rear_x, rear_y = self.x - lever * math.cos(self.yaw), self.y - lever * math.sin(self.yaw)
        middle = self.yaw + bend * way / 2
        rear_x, rear_y = rear_x + way * math.cos(middle), rear_y + way * math.sin(middle)
        self.yaw += bend * way
        self.x, self.y = rear_x + lever * math.cos(self.yaw), rear_y + lever * math.sin(self.yaw)

    def _steer(self, t: float, dt: float) -> None:
        """Turn the front wheels so that the center returns to the path."""
        if self._track is None or self._order is None:
            return
        if self._order.reverse:
            self._track.advance(self.x, self.y)
            self.steer = 0.0
            return
        offset, direction, curvature = self._track.advance(self.x, self.y)
        lever = WHEELBASE_M / 2
        course = self.yaw + math.atan(lever / WHEELBASE_M * math.tan(self.steer))
        error = offset - self.manner.drift_at(t)
        approach = min(max(-error / REACH_M, -APPROACH_RAD), APPROACH_RAD)
        bend = curvature + wrapped(direction + approach - course) * 2.0 / REACH_M
        wanted = min(max(math.atan(WHEELBASE_M * bend), -LOCK_RAD), LOCK_RAD)
        most = STEERS_RADPS * dt
        self.steer += min(max(wanted - self.steer, -most), most)
