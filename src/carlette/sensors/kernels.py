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


def compiled(function: Function) -> Function:
    """Compiles a function; where the file system takes no cache, anew in every process."""
    njit: Any = numba.njit
    try:
        built: Function = njit(function, cache=True, nogil=True, error_model="numpy")
    except RuntimeError:
        built = njit(function, nogil=True, error_model="numpy")
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
    distance: Array,
    hit: Array,
) -> None:
    """The nearest front face on each ray.

    `corners` is (n, 4, 3), flat convex quads in the frames of their bodies; body `i` owns `spans[i, 0]` up to
    `spans[i, 1]` and is turned by `turns[i]` (3x3) and moved by `shifts[i]` into the sensor's frame. `azimuths` (m) are
    ascending, within -π to π; `tangents` is (1, k) for all columns or (m, k). Writes `distance` (m, k), metres, where
    a face is nearer than what it holds, and `hit` (m, k), `base` plus the index of the quad.

    Within one column, a quad covers an interval of tangents: each edge and the sensor span a plane, which gives a
    linear bound. So only the rays that truly meet the quad are touched.
    """
    rows = tangents.shape[0]
    channels = tangents.shape[1]
    cosines = 1.0 / np.sqrt(1.0 + tangents * tangents)
    ahead = np.cos(azimuths)
    aside = np.sin(azimuths)
    p = np.empty((4, 3))
    e = np.empty((4, 3))
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
            if offset >= 0.0 or offset * offset >= reach * reach * (nx * nx + ny * ny + nz * nz):
                continue
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
                        rise = e[i, 2]
                        if rise > 0.0:
                            least = max(least, -level / rise)
                        elif rise < 0.0:
                            most = min(most, -level / rise)
                        elif level < 0.0:
                            most = -1e31
                    if least > most:
                        continue
                    row = column if rows > 1 else 0
                    flat = nx * ca + ny * sa
                    channel = np.searchsorted(tangents[row], least)
                    while channel < channels and tangents[row, channel] <= most:
                        slope = cosines[row, channel] * (flat + nz * tangents[row, channel])
                        if slope < 0.0:
                            found = offset / slope
                            if found < distance[column, channel]:
                                distance[column, channel] = found
                                hit[column, channel] = base + quad
                        channel += 1


@compiled
def pack_points(
    distance: Array,
    hit: Array,
    place: Array,
    order: Array,
    azimuths: Array,
    tangents: Array,
    losses: Array,
    chances: Array,
    noise: Array,
    points: Array,
    faces: Array,
) -> Array:
    """The points of a scan as LiDARs send them, channel after channel; returns how many each channel has.

    `distance` and `hit` are (m, k) as `scan` leaves them. `place` (m) is the column of each step of the sweep in the
    order of time, `order` (k) the row of `tangents` of each channel. `losses` are the share of rays that never leave,
    the attenuation (1/m), and what a point with an intensity below the third is kept by: the chance is the fourth
    times the intensity plus the fifth. `chances` (2, k, m), uniform, decide; `noise` (k, m) lengthens the rays, metres;
    where they are empty, all is kept as it is. Writes x, y, z, intensity to `points` (n, 4) and the face to `faces`.
    """
    steps, channels = distance.shape
    counts = np.zeros(channels, np.uint32)
    ahead = np.cos(azimuths)
    aside = np.sin(azimuths)
    number = 0
    for channel in range(channels):
        row = order[channel]
        tangent = tangents[row]
        cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
        for step in range(steps):
            column = place[step]
            face = hit[column, row]
            if face < 0:
                continue
            intensity = np.exp(-losses[1] * distance[column, row])
            if chances.size:
                if chances[0, channel, step] < losses[0]:
                    continue
                if intensity <= losses[2] and chances[1, channel, step] >= losses[3] * intensity + losses[4]:
                    continue
            far = distance[column, row] + (noise[channel, step] if noise.size else 0.0)
            flat = far * cosine
            points[number, 0] = flat * ahead[column]
            points[number, 1] = flat * aside[column]
            points[number, 2] = flat * tangent
            points[number, 3] = intensity
            faces[number] = face
            number += 1
            counts[channel] += 1
    return counts
