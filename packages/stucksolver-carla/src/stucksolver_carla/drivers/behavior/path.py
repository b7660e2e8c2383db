"""Represents a line to drive along: arc length, heading, curvature and speed bounds of a sampled polyline.

The frame is CARLA's world frame (x east, y south, m), with clockwise yaw (rad). Lateral offsets and curvature are
positive to the right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.polyline import arc_lengths

Array = NDArray[np.float64]
SPACING_M = 0.25
"""Distance between two samples of a path (m). Ours."""
_HEADING_BASE_M = 0.5
"""Distance to either side over which the heading is measured (m). Ours."""
_CURVATURE_BASE_M = 1.0
"""Distance to either side over which the curvature is measured (m). Ours."""
_MIN_STEP_M = 0.02
"""Minimum distance between two input points (m); nearer ones are dropped, because their direction is noise. Ours."""


class PlanarPose(NamedTuple):
    """A position and heading in CARLA's world frame (m, rad)."""

    x: float
    y: float
    yaw: float


def flipped(pose: PlanarPose) -> PlanarPose:
    """Return the same position with the opposite heading, for a car that backs up."""
    return PlanarPose(pose.x, pose.y, pose.yaw + math.pi)


class Projection(NamedTuple):
    """Position of a pose relative to a path."""

    s: float
    """Arc length of the nearest point (m)."""
    lateral: float
    """Offset from the path (m), right positive."""
    heading: float
    """The pose's heading minus the path's (rad), in [-pi, pi]."""


@dataclass(frozen=True, eq=False)
class Path:
    """Samples of a line every quarter meter; arrays of equal length."""

    s: Array
    x: Array
    y: Array
    z: Array
    yaw: Array
    """Unwrapped headings (rad): two neighbors never differ by a full turn."""
    curvature: Array
    speed: Array
    """Upper bound of the speed at each sample (m/s)."""

    @property
    def length(self) -> float:
        """Arc length of the whole path (m)."""
        return float(self.s[-1])

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return x, y and yaw at the arc lengths `s`. Beyond either end the path continues straight."""
        beyond_m = s - np.clip(s, 0.0, self.length)
        yaw = np.interp(s, self.s, self.yaw)
        x = np.interp(s, self.s, self.x) + beyond_m * np.cos(yaw)
        y = np.interp(s, self.s, self.y) + beyond_m * np.sin(yaw)
        return x, y, yaw

    def curvature_at(self, s: float) -> float:
        """Return the curvature at arc length `s` (1/m), right positive."""
        return float(np.interp(s, self.s, self.curvature))

    def speed_at(self, s: float) -> float:
        """Return the speed bound at arc length `s` (m/s)."""
        return float(np.interp(s, self.s, self.speed))

    def project(self, pose: PlanarPose, near_s: float | None = None, window_m: float = 30.0) -> Projection:
        """Return the nearest point of the path, from a little behind `near_s` to `window_m` ahead of it.

        Points whose heading differs by more than 90 degrees are used only without any other. So a path that passes a
        place twice is not entered in the opposite direction.
        """
        lo, hi = 0, len(self.s)
        if near_s is not None:
            lo = int(np.searchsorted(self.s, near_s - 3.0))
            hi = max(int(np.searchsorted(self.s, near_s + window_m)), lo + 2)
            lo = min(lo, len(self.s) - 2)
        dx, dy = pose.x - self.x[lo:hi], pose.y - self.y[lo:hi]
        opposite = np.cos(self.yaw[lo:hi] - pose.yaw) < 0.0
        i = lo + int(np.argmin(dx * dx + dy * dy + 1e6 * opposite))
        yaw = float(self.yaw[i])
        dx_i, dy_i = pose.x - float(self.x[i]), pose.y - float(self.y[i])
        along = dx_i * math.cos(yaw) + dy_i * math.sin(yaw)
        lateral = dy_i * math.cos(yaw) - dx_i * math.sin(yaw)
        if 0 < i < len(self.s) - 1:
            along = min(max(along, -SPACING_M), SPACING_M)
        return Projection(float(self.s[i]) + along, lateral, math.remainder(pose.yaw - yaw, math.tau))


def make_path(x: Array, y: Array, speed: Array, z: Array | None = None) -> Path:
    """Return a resampled path through points.

    Raises:
        ValueError: All points have the same position.
    """
    steps = np.hypot(np.diff(x), np.diff(y))
    keep = np.concatenate([[True], steps > _MIN_STEP_M])
    x, y, speed = x[keep], y[keep], speed[keep]
    z = np.zeros_like(x) if z is None else z[keep]
    if len(x) < 2:
        raise ValueError(f"a path must have two points at least {_MIN_STEP_M} m apart, got {len(keep)} point(s)")
    arc = arc_lengths(np.column_stack([x, y]))
    s = np.linspace(0.0, arc[-1], max(int(arc[-1] / SPACING_M) + 1, 2))
    xs, ys = _smoothed(s, np.interp(s, arc, x)), _smoothed(s, np.interp(s, arc, y))
    yaw = _heading(s, xs, ys)
    bounds = np.interp(s, arc, speed)
    return Path(s, xs, ys, np.interp(s, arc, z), yaw, _slope(s, yaw, _CURVATURE_BASE_M), bounds)


def limited_speed(s: Array, bound: Array, deceleration: float) -> Array:
    """Return bounds that are lowered so that at most `deceleration` (m/s²) leads to each lower bound ahead."""
    reachable = bound * bound + 2.0 * deceleration * s
    # v(s)^2 <= v(t)^2 + 2 a (t - s) for every t >= s: a running minimum from the far end.
    lowest = np.minimum.accumulate(reachable[::-1])[::-1]
    return np.asarray(np.sqrt(np.maximum(lowest - 2.0 * deceleration * s, 0.0)))


def _smoothed(s: Array, values: Array) -> Array:
    """Return a polyline with rounded corners: a mean over one meter that keeps both ends."""
    reach = min(max(round(_HEADING_BASE_M / max(float(s[1]), 1e-6)), 1), (len(values) - 1) // 2)
    if reach < 1:
        return values
    # Odd reflection at the ends keeps position and direction there.
    head, tail = 2.0 * values[0] - values[reach:0:-1], 2.0 * values[-1] - values[-2 : -reach - 2 : -1]
    padded = np.concatenate([head, values, tail])
    kernel = np.ones(2 * reach + 1) / (2 * reach + 1)
    return np.asarray(np.convolve(padded, kernel, mode="valid"))


def _heading(s: Array, x: Array, y: Array) -> Array:
    return np.asarray(np.unwrap(np.arctan2(_slope(s, y, _HEADING_BASE_M), _slope(s, x, _HEADING_BASE_M))))


def _slope(s: Array, values: Array, base_m: float) -> Array:
    """Return the central difference over `base_m` to either side, one-sided at the ends."""
    a, b = np.maximum(s - base_m, s[0]), np.minimum(s + base_m, s[-1])
    return np.asarray((np.interp(b, s, values) - np.interp(a, s, values)) / (b - a))
