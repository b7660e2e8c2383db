"""The inner loops of LiDAR and radar, compiled by numba on first use; the machine code is cached for later runs.

All of them work in the sensor's frame, so a tilted sensor costs nothing extra. A ray is a column (its azimuth) and a
channel (its elevation). `tangents` are tan(elevation), ascending.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from carlette.jit import compiled

Array = Any
"""A numpy array, as numba types it."""


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
    """Find the nearest front face on each ray.

    `corners` is (n, 4, 3), flat convex quads in the frames of their bodies. Body `i` owns `spans[i, 0]` up to `spans[i,
    1]`. It is turned by `turns[i]` (3x3) and moved by `shifts[i]` (m) into the sensor's frame. `azimuths` (m) are
    ascending, within -π to π; `tangents` is (1, k) for all columns or (m, k). The function writes `nearness` (m, k),
    the inverse of the distance (1/m), where a face is nearer than the stored one, and `hit` (m, k), `base` plus the
    quad's index. `gaps[base + quad]` gets the distance of each front face's plane. Divided by the distance of a point,
    it is the cosine of its incidence.

    Within one column, a quad covers an interval of tangents: each edge and the sensor span a plane, which gives a
    linear bound. Therefore only the rays that hit the quad are processed.
    """
    cosines = 1.0 / np.sqrt(1.0 + tangents * tangents)
    ahead, aside = np.cos(azimuths), np.sin(azimuths)
    lowest, finest = tangents[0, 0], 4 * tangents.shape[1]
    scale = finest / max(tangents[0, -1] - lowest, 1e-9)
    starts_at = np.empty(finest + 1, np.int64)
    for cell in range(finest + 1):
        starts_at[cell] = _below(tangents[0], lowest + cell / scale)
    p, e, tilt = np.empty((4, 3)), np.empty((4, 3)), np.empty(4)
    for body in range(spans.shape[0]):
        for quad in range(spans[body, 0], spans[body, 1]):
            _place(corners[quad], turns[body], shifts[body], p)
            nx, ny, nz, offset, gap = _plane(p)
            if offset >= 0.0 or gap >= reach:
                continue
            gaps[base + quad] = gap
            if _nearest(p) >= reach:
                continue
            low, high = _edges(p, e, tilt)
            wx, wy, wz = nx / offset, ny / offset, nz / offset
            # A quad behind the sensor covers both ends of the azimuths.
            for part in range(-1, 2):
                start, end = low + 2.0 * np.pi * part, high + 2.0 * np.pi * part
                if end < -np.pi or start > np.pi or (part and high - low >= 2.0 * np.pi):
                    continue
                first, last = _below(azimuths, start - 1e-9), _below(azimuths, end + 1e-9)
                for column in range(first, last):
                    least, most = _interval(e, tilt, ahead[column], aside[column])
                    if least > most:
                        continue
                    row = column if tangents.shape[0] > 1 else 0
                    # A table leads close to the first channel of the interval. It exists only if all columns share
                    # their tangents.
                    channel = 0
                    if tangents.shape[0] == 1 and least > lowest:
                        channel = starts_at[int(min((least - lowest) * scale, finest))]
                        channel -= channel > 0
                    flat = wx * ahead[column] + wy * aside[column]
                    _fill(
                        tangents[row], cosines[row], channel, least, most, flat, wz,
                        base + quad, nearness[column], hit[column],
                    )  # fmt: skip


@compiled
def _below(values: Array, bound: float) -> int:
    """Return the number of ascending `values` below `bound`. The function of numpy takes a second to compile."""
    low, high = 0, len(values)
    while low < high:
        middle = (low + high) >> 1
        if values[middle] < bound:
            low = middle + 1
        else:
            high = middle
    return low


@compiled
def _place(corners: Array, turn: Array, shift: Array, p: Array) -> None:
    """Write a quad's corners in the sensor's frame into `p` (4, 3)."""
    for i in range(4):
        x, y, z = corners[i, 0], corners[i, 1], corners[i, 2]
        for k in range(3):
            p[i, k] = turn[k, 0] * x + turn[k, 1] * y + turn[k, 2] * z + shift[k]


@compiled
def _plane(p: Array) -> tuple[float, float, float, float, float]:
    """Return a quad's normal, its offset (normal times corner; negative = front side), and its distance."""
    ux, uy, uz = p[2, 0] - p[0, 0], p[2, 1] - p[0, 1], p[2, 2] - p[0, 2]
    vx, vy, vz = p[3, 0] - p[1, 0], p[3, 1] - p[1, 1], p[3, 2] - p[1, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    offset = nx * p[0, 0] + ny * p[0, 1] + nz * p[0, 2]
    return nx, ny, nz, offset, -offset / np.sqrt(nx * nx + ny * ny + nz * nz)


@compiled
def _nearest(p: Array) -> float:
    """Return a lower bound on a quad's distance: the distance of its center minus its radius."""
    mx = 0.25 * (p[0, 0] + p[1, 0] + p[2, 0] + p[3, 0])
    my = 0.25 * (p[0, 1] + p[1, 1] + p[2, 1] + p[3, 1])
    mz = 0.25 * (p[0, 2] + p[1, 2] + p[2, 2] + p[3, 2])
    size = 0.0
    for i in range(4):
        gx, gy, gz = p[i, 0] - mx, p[i, 1] - my, p[i, 2] - mz
        size = max(size, gx * gx + gy * gy + gz * gz)
    return float(np.sqrt(mx * mx + my * my + mz * mz) - np.sqrt(size))


@compiled
def _edges(p: Array, e: Array, tilt: Array) -> tuple[float, float]:
    """Write the planes of the edges and the sensor into `e` (4, 3) and `tilt` (4); return the span of azimuths."""
    middle = np.arctan2(p[0, 1] + p[1, 1] + p[2, 1] + p[3, 1], p[0, 0] + p[1, 0] + p[2, 0] + p[3, 0])
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
    if high - low >= np.pi - 1e-9:  # above or below the sensor: all around
        return -np.pi, np.pi
    return middle + low, middle + high


@compiled
def _interval(e: Array, tilt: Array, ahead: float, aside: float) -> tuple[float, float]:
    """Return the interval of tangents in which a column meets a quad; empty if the first is larger."""
    least, most = -1e30, 1e30
    for i in range(4):
        level = e[i, 0] * ahead + e[i, 1] * aside
        if tilt[i] < 0.0:
            least = max(least, level * tilt[i])
        elif tilt[i] > 0.0:
            most = min(most, level * tilt[i])
        elif level < 0.0:
            most = -1e31
    return least, most


@compiled
def _fill(
    tangents: Array,
    cosines: Array,
    channel: int,
    least: float,
    most: float,
    flat: float,
    steep: float,
    face: int,
    nearness: Array,
    hit: Array,
) -> None:
    """Record a face on the rays of one column within an interval of tangents, unless a nearer one is recorded."""
    while channel < len(tangents) and tangents[channel] < least:
        channel += 1
    while channel < len(tangents) and tangents[channel] <= most:
        near = cosines[channel] * (flat + steep * tangents[channel])
        if near > nearness[channel]:
            nearness[channel] = near
            hit[channel] = face
        channel += 1


@compiled
def place_points(
    nearness: Array,
    is_kept: Array,
    column_of: Array,
    starts: Array,
    ways: Array,
    levels: Array,
    off: Array,
    intensity: Array,
    points: Array,
    sources: Array,
) -> None:
    """Write x, y, z and intensity of the rays that were kept, channel after channel, each in the order of time.

    `column_of` (m) is the column of each step. `starts` (k) is the start of each row of tangents in `points` (n, 4) and
    `sources` (n), which gets the flat index of the ray. `ways` (m, 2) and `levels` (k, 2) are cosine and sine of
    azimuths and elevations. `intensity` is (m, k). `off` (m, k) lengthens the rays (m), unless it is empty.
    """
    places = starts.copy()
    channels = is_kept.shape[1]
    for step in range(len(column_of)):
        column = column_of[step]
        for row in range(channels):
            if is_kept[column, row]:
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


@compiled
def label_points(
    points: Array,
    sources: Array,
    nearness: Array,
    hit: Array,
    gaps: Array,
    actors: Array,
    tags: Array,
    rows: Array,
    labels: Array,
) -> None:
    """Write x, y, z, the cosine of the incidence, the actor's id and the tag of each point.

    `rows` (n, 6) float32 and `labels` share their memory; `labels` is uint32. The others are those of `place_points`
    and `scan`.
    """
    channels = hit.shape[1]
    for number in range(len(points)):
        column, row = divmod(sources[number], channels)
        face = hit[column, row]
        rows[number, 0] = points[number, 0]
        rows[number, 1] = points[number, 1]
        rows[number, 2] = points[number, 2]
        rows[number, 3] = nearness[column, row] * gaps[face]
        labels[number, 4] = actors[face]
        labels[number, 5] = tags[face]


@lru_cache(maxsize=1)
def warm_up() -> None:
    """Cast one ray at one wall. After that, no call compiles anything."""
    wall = np.array([[(5, -1, -1), (5, -1, 1), (5, 1, 1), (5, 1, -1)]], np.float32)
    nearness, hit, gaps = np.full((1, 1), 0.1, np.float32), np.full((1, 1), -1, np.int32), np.zeros(1, np.float32)
    body = (wall, np.array([[0, 1]]), np.eye(3)[None], np.zeros((1, 3)))
    scan(*body, np.zeros(1), np.zeros((1, 1)), 10.0, 0, nearness, hit, gaps)
    is_kept, start, flat = np.ones((1, 1), bool), np.zeros(1, np.int64), np.ones((1, 2))
    points, sources = np.empty((1, 4), np.float32), np.empty(1, np.int64)
    place_points(nearness, is_kept, start, start, flat, flat, np.zeros((0, 0), np.float32), nearness, points, sources)
    of_face, rows = np.zeros(1, np.uint32), np.empty((1, 6), np.float32)
    label_points(points, sources, nearness, hit, gaps, of_face, of_face, rows, rows.view(np.uint32))
