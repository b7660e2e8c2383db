"""The inner loops of LiDAR and radar, compiled by numba on first use; the machine code is kept for later runs.

All of it works in the sensor's frame, so a tilted sensor costs nothing extra. A ray is a column (its azimuth) and a
channel (its elevation); `tangents` are tan(elevation), ascending.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba
import numpy as np

Function = TypeVar("Function", bound=Callable[..., Any])
Array = Any
"""A numpy array, as numba sees it."""
# Products must not be fused with sums: an edge has to bound both faces that share it by the same number.
_OPTIONS = {"nogil": True, "error_model": "numpy", "fastmath": {"nnan", "ninf", "nsz"}}


def compiled(function: Function) -> Function:
    """Compiles a function; where the file system takes no cache, anew in every process."""
    njit: Any = numba.njit
    try:
        built: Function = njit(function, cache=True, **_OPTIONS)
    except RuntimeError:
        built = njit(function, **_OPTIONS)
    return built


@compiled
def scan(
    corners: Array,
    spans: Array,
    turns: Array,
    shifts: Array,
    azimuths: Array,
    tangents: Array,
    reach: float,
    base: int,
    nearness: Array,
    hit: Array,
    gaps: Array,
) -> None:
    """The nearest front face on each ray.

    `corners` is (n, 4, 3), flat convex quads in the frames of their bodies; body `i` owns `spans[i, 0]` up to
    `spans[i, 1]` and is turned by `turns[i]` (3x3) and moved by `shifts[i]` into the sensor's frame. `azimuths` (m) are
    ascending, within -π to π; `tangents` is (1, k) for all columns or (m, k). Writes `nearness` (m, k), one through the
    distance in metres, where a face is nearer than what it holds, and `hit` (m, k), `base` plus the quad's index.
    `gaps[base + quad]` gets the distance of each front face's plane: that over the distance of a point is the cosine of
    its incidence.

    Within one column, a quad covers an interval of tangents: each edge and the sensor span a plane, which gives a
    linear bound. So only the rays that truly meet the quad are touched.
    """
    rows = tangents.shape[0]
    channels = tangents.shape[1]
    cosines = 1.0 / np.sqrt(1.0 + tangents * tangents)
    ahead = np.cos(azimuths)
    aside = np.sin(azimuths)
    lowest, finest = tangents[0, 0], 4 * channels
    scale = finest / max(tangents[0, channels - 1] - lowest, 1e-9)
    starts_at = np.searchsorted(tangents[0], lowest + np.arange(finest + 1) / scale)
    p = np.empty((4, 3))
    e = np.empty((4, 3))
    tilt = np.empty(4)
    for body in range(spans.shape[0]):
        turn = turns[body]
        shift = shifts[body]
        for quad in range(spans[body, 0], spans[body, 1]):
            mx = my = mz = 0.0
            for i in range(4):
                x, y, z = corners[quad, i, 0], corners[quad, i, 1], corners[quad, i, 2]
                p[i, 0] = turn[0, 0] * x + turn[0, 1] * y + turn[0, 2] * z + shift[0]
                p[i, 1] = turn[1, 0] * x + turn[1, 1] * y + turn[1, 2] * z + shift[1]
                p[i, 2] = turn[2, 0] * x + turn[2, 1] * y + turn[2, 2] * z + shift[2]
                mx += 0.25 * p[i, 0]
                my += 0.25 * p[i, 1]
                mz += 0.25 * p[i, 2]
            ux, uy, uz = p[2, 0] - p[0, 0], p[2, 1] - p[0, 1], p[2, 2] - p[0, 2]
            vx, vy, vz = p[3, 0] - p[1, 0], p[3, 1] - p[1, 1], p[3, 2] - p[1, 2]
            nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            offset = nx * p[0, 0] + ny * p[0, 1] + nz * p[0, 2]
            length = np.sqrt(nx * nx + ny * ny + nz * nz)
            if offset >= 0.0 or -offset >= reach * length:
                continue
            gaps[base + quad] = -offset / length
            size = 0.0
            for i in range(4):
                gx, gy, gz = p[i, 0] - mx, p[i, 1] - my, p[i, 2] - mz
                size = max(size, gx * gx + gy * gy + gz * gz)
            if np.sqrt(mx * mx + my * my + mz * mz) - np.sqrt(size) >= reach:
                continue
            middle = np.arctan2(my, mx)
            low, high = 0.0, 0.0
            for i in range(4):
                j = (i + 1) % 4
                e[i, 0] = p[i, 2] * p[j, 1] - p[i, 1] * p[j, 2]
                e[i, 1] = p[i, 0] * p[j, 2] - p[i, 2] * p[j, 0]
                e[i, 2] = p[i, 1] * p[j, 0] - p[i, 0] * p[j, 1]
                tilt[i] = -1.0 / e[i, 2] if e[i, 2] != 0.0 else 0.0
                gap = np.arctan2(p[i, 1], p[i, 0]) - middle
                if gap > np.pi:
                    gap -= 2.0 * np.pi
                elif gap < -np.pi:
                    gap += 2.0 * np.pi
                low, high = min(low, gap), max(high, gap)
            if high - low >= np.pi - 1e-9:
                starts, ends = (-np.pi, 4.0, 4.0), (np.pi, 4.0, 4.0)
            else:
                low, high = middle + low, middle + high
                starts = (low, low + 2.0 * np.pi, low - 2.0 * np.pi)
                ends = (high, high + 2.0 * np.pi, high - 2.0 * np.pi)
            wx, wy, wz = nx / offset, ny / offset, nz / offset
            for part in range(3):
                if ends[part] < -np.pi or starts[part] > np.pi:
                    continue
                first = np.searchsorted(azimuths, starts[part] - 1e-9)
                last = np.searchsorted(azimuths, ends[part] + 1e-9)
                for column in range(first, last):
                    ca, sa = ahead[column], aside[column]
                    least, most = -1e30, 1e30
                    for i in range(4):
                        level = e[i, 0] * ca + e[i, 1] * sa
                        if tilt[i] < 0.0:
                            least = max(least, level * tilt[i])
                        elif tilt[i] > 0.0:
                            most = min(most, level * tilt[i])
                        elif level < 0.0:
                            most = -1e31
                    if least > most:
                        continue
                    row = column if rows > 1 else 0
                    flat = wx * ca + wy * sa
                    # A table leads close to the first channel of the interval; for rays of their own, there is one.
                    channel = 0
                    if rows == 1 and least > lowest:
                        channel = starts_at[int(min((least - lowest) * scale, finest))]
                        channel -= channel > 0
                    while channel < channels and tangents[row, channel] < least:
                        channel += 1
                    while channel < channels and tangents[row, channel] <= most:
                        near = cosines[row, channel] * (flat + wz * tangents[row, channel])
                        if near > nearness[column, channel]:
                            nearness[column, channel] = near
                            hit[column, channel] = base + quad
                        channel += 1


@compiled
def place_points(
    nearness: Array,
    kept: Array,
    column_of: Array,
    starts: Array,
    ways: Array,
    levels: Array,
    off: Array,
    intensity: Array,
    points: Array,
    sources: Array,
) -> None:
    """Writes x, y, z and intensity of the rays that were kept, channel after channel, each in the order of time.

    `column_of` (m) is the column of each step; `starts` (k) where each row of tangents begins in `points` (n, 4)
    and `sources` (n), which gets the flat index of the ray; `ways` (m, 2) and `levels` (k, 2) are cosine and sine of
    azimuths and elevations; `intensity` is (m, k); `off` (m, k) lengthens the rays, metres, unless it is empty.
    """
    places = starts.copy()
    channels = kept.shape[1]
    for step in range(len(column_of)):
        column = column_of[step]
        for row in range(channels):
            if kept[column, row]:
                far = 1.0 / nearness[column, row]
                if off.size:
                    far += off[column, row]
                number = places[row]
                places[row] = number + 1
                flat = far * levels[row, 0]
                points[number, 0] = flat * ways[column, 0]
                points[number, 1] = flat * ways[column, 1]
                points[number, 2] = far * levels[row, 1]
                points[number, 3] = intensity[column, row]
                sources[number] = column * channels + row
