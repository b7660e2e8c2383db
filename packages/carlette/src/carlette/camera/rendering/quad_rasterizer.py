"""The inner loops of the rasterizer, compiled by numba on first use; the machine code is cached for later runs.

A quad is drawn where it covers the center of a pixel. The depth buffer holds nearness, the inverse of the distance
ahead: it is linear across the picture on every plane, and most precise close to the camera. An edge that two quads
share is computed from the same two points in the same order, so that no pixel between them is missed or drawn twice.
Colors that vary across a quad are interpolated on each of its two triangles as in Olano and Greer, "Triangle Scan
Conversion using 2D Homogeneous Coordinates" (1997), which is correct in perspective.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from carlette.camera.arrays import Pixels
from carlette.camera.rendering.view import NEAR_M
from carlette.jit import compiled

Array = Any
"""A numpy array, as numba types it."""
FLAT_M = 0.002
"""Largest distance of a corner from the plane of the other three (m).

Beyond it a quad is split into two triangles. Ours.
"""
# A shade is four bytes in one number. The constants have its type, because numba would compute with 64 bits otherwise.
_BYTE = numba.uint32(0xFF)
_OPAQUE = numba.uint32(0xFF000000)
_SECOND = numba.uint32(8)
_THIRD = numba.uint32(16)
_ALPHA = numba.uint32(24)
_ZERO = np.float32(0.0)
_HALF = np.float32(0.5)
_ONE = np.float32(1.0)
_MOST = np.float32(255.0)


@compiled
def draw_quads(
    corners: Array,
    shades: Array,
    matrix: Array,
    across: float,
    up: float,
    adds: bool,
    tests_depth: bool,
    pixels: Array,
    nearness: Array,
) -> None:
    """Draw `corners` (n, 4, 3) in `shades` (n, 4) uint32, one for each corner, into `pixels` and `nearness` (h, w).

    `matrix` (4, 4) maps into the camera's frame (x ahead, y right, z up); `across` and `up` are half the picture's
    width and height at a distance of one meter. Shades are blended by their alpha or, with `adds`, added as light.
    """
    height, width = pixels.shape
    lens = (0.5 * width / across, 0.5 * height / up, 0.5 * width, 0.5 * height)
    p, q = np.empty((4, 3)), np.empty((3, 3))
    clipped, outline = np.empty((6, 3)), np.empty((6, 2))
    levels = np.empty((4, 3))
    for quad in range(corners.shape[0]):
        if not _place(corners[quad], matrix, across, up, p):
            continue
        item, two, three, four = shades[quad, 0], shades[quad, 1], shades[quad, 2], shades[quad, 3]
        is_plain = item == two and item == three and item == four
        is_solid = not adds and item & two & three & four >= _OPAQUE
        nx, ny, nz = _normal(p, 1, 3)
        offset = nx * p[0, 0] + ny * p[0, 1] + nz * p[0, 2]
        rise = nx * p[2, 0] + ny * p[2, 1] + nz * p[2, 2] - offset
        is_flat = rise * rise <= FLAT_M * FLAT_M * (nx * nx + ny * ny + nz * nz)
        if is_plain and is_flat:
            if offset < 0.0:
                count = _outline(p, 4, lens, clipped, outline)
                plane = (nx / offset, ny / offset, nz / offset)
                _fill_plain(outline, count, plane, lens, item, is_solid, adds, tests_depth, pixels, nearness)
            continue
        for half in range(2):
            nx, ny, nz = _normal(p, half + 1, half + 2)
            offset = nx * p[0, 0] + ny * p[0, 1] + nz * p[0, 2]
            if offset >= 0.0:
                continue
            q[0], q[1], q[2] = p[0], p[half + 1], p[half + 2]
            count = _outline(q, 3, lens, clipped, outline)
            plane = (nx / offset, ny / offset, nz / offset)
            if is_plain:
                _fill_plain(outline, count, plane, lens, item, is_solid, adds, tests_depth, pixels, nearness)
            else:
                second, third = (two, three) if half == 0 else (three, four)
                _weigh(q, offset, (item, second, third), levels)
                _fill_shaded(outline, count, plane, lens, levels, is_solid, adds, tests_depth, pixels, nearness)


@compiled
def _place(corners: Array, matrix: Array, across: float, up: float, p: Array) -> bool:
    """Write a quad in the camera's frame; False if it is outside or behind the picture."""
    behind = left = right = above = below = 0
    for k in range(4):
        x, y, z = np.float64(corners[k, 0]), np.float64(corners[k, 1]), np.float64(corners[k, 2])
        for i in range(3):
            p[k, i] = matrix[i, 0] * x + matrix[i, 1] * y + matrix[i, 2] * z + matrix[i, 3]
        wide, tall = p[k, 0] * across, p[k, 0] * up
        behind += p[k, 0] < NEAR_M
        left += p[k, 1] < -wide
        right += p[k, 1] > wide
        above += p[k, 2] > tall
        below += p[k, 2] < -tall
    return behind < 4 and left < 4 and right < 4 and above < 4 and below < 4


@compiled
def _normal(p: Array, second: int, last: int) -> tuple[float, float, float]:
    ax, ay, az = p[second, 0] - p[0, 0], p[second, 1] - p[0, 1], p[second, 2] - p[0, 2]
    bx, by, bz = p[last, 0] - p[0, 0], p[last, 1] - p[0, 1], p[last, 2] - p[0, 2]
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@compiled
def _outline(p: Array, count: int, lens: tuple[float, float, float, float], clipped: Array, outline: Array) -> int:
    """Clip the part nearer than `NEAR_M` and project the rest: pixels u, v. Returns the number of corners."""
    found = 0
    for k in range(count):
        n = k + 1 if k + 1 < count else 0
        here, there = p[k, 0] - NEAR_M, p[n, 0] - NEAR_M
        if here >= 0.0:
            clipped[found] = p[k]
            found += 1
        if (here >= 0.0) != (there >= 0.0):
            # The computation starts at the same end for both directions of the edge.
            a, b = (k, n) if here >= 0.0 else (n, k)
            share = (p[a, 0] - NEAR_M) / (p[a, 0] - p[b, 0])
            clipped[found, 0] = NEAR_M
            for i in range(1, 3):
                clipped[found, i] = p[a, i] + share * (p[b, i] - p[a, i])
            found += 1
    wide, tall, middle_u, middle_v = lens
    for k in range(found):
        outline[k, 0] = middle_u + wide * clipped[k, 1] / clipped[k, 0]
        outline[k, 1] = middle_v - tall * clipped[k, 2] / clipped[k, 0]
    return found


@compiled
def _rows(outline: Array, count: int, height: int) -> tuple[int, int]:
    low = high = outline[0, 1]
    for k in range(1, count):
        low, high = min(low, outline[k, 1]), max(high, outline[k, 1])
    return int(np.ceil(min(max(low, 0.0), height) - 0.5)), int(np.ceil(min(max(high, 0.0), height) - 0.5))


@compiled
def _span(outline: Array, count: int, row: int, width: int) -> tuple[int, int]:
    """Return first pixel of a row whose middle is inside, and the one after the last."""
    y = row + 0.5
    left, right = np.inf, -np.inf
    for k in range(count):
        n = k + 1 if k + 1 < count else 0
        # An edge is computed from its upper end for both directions.
        a, b = (k, n) if outline[k, 1] < outline[n, 1] else (n, k)
        if outline[a, 1] <= y < outline[b, 1]:
            slope = (outline[b, 0] - outline[a, 0]) / (outline[b, 1] - outline[a, 1])
            x = outline[a, 0] + (y - outline[a, 1]) * slope
            left, right = min(left, x), max(right, x)
    if left > right:
        return 0, 0
    return int(np.ceil(min(max(left, 0.0), width) - 0.5)), int(np.ceil(min(max(right, 0.0), width) - 0.5))


@compiled
def _fill_plain(
    outline: Array,
    count: int,
    plane: tuple[float, float, float],
    lens: tuple[float, float, float, float],
    shade: Any,
    is_solid: bool,
    adds: bool,
    tests_depth: bool,
    pixels: Array,
    nearness: Array,
) -> None:
    """Fill an outline with one shade. `plane` is its normal through its offset, so that n.(1, y/x, z/x) = 1/x."""
    if count < 3:
        return
    height, width = pixels.shape
    wide, tall, middle_u, middle_v = lens
    step = np.float32(plane[1] / wide)
    top, bottom = _rows(outline, count, height)
    for row in range(top, bottom):
        first, end = _span(outline, count, row, width)
        if first >= end:
            continue
        start = np.float32(
            plane[0] + plane[1] * (first + 0.5 - middle_u) / wide + plane[2] * (middle_v - row - 0.5) / tall
        )
        near, into = nearness[row, first:end], pixels[row, first:end]
        if is_solid and tests_depth:
            for k in range(end - first):
                here = start + np.float32(k) * step
                is_nearer = here > near[k]
                near[k] = here if is_nearer else near[k]
                into[k] = shade if is_nearer else into[k]
            continue
        for k in range(end - first):
            here = start + np.float32(k) * step
            if not tests_depth or here > near[k]:
                if tests_depth:
                    near[k] = here
                into[k] = shade if is_solid else _blended(into[k], shade, adds)


@compiled
def _weigh(q: Array, offset: float, shades: tuple[Any, Any, Any], levels: Array) -> None:
    """Write each byte of a triangle's shade, times nearness, as a linear function of (1, y/x, z/x): (4, 3)."""
    levels[:] = 0.0
    for k in range(3):
        a, b = q[(k + 1) % 3], q[(k + 2) % 3]
        weight = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        for byte in range(4):
            value = np.float64(shades[k] >> numba.uint32(8 * byte) & _BYTE) / offset
            for i in range(3):
                levels[byte, i] += value * weight[i]


@compiled
def _fill_shaded(
    outline: Array,
    count: int,
    plane: tuple[float, float, float],
    lens: tuple[float, float, float, float],
    levels: Array,
    is_solid: bool,
    adds: bool,
    tests_depth: bool,
    pixels: Array,
    nearness: Array,
) -> None:
    """Fill a triangle's outline with shades that change from corner to corner. `levels` comes from `_weigh`."""
    if count < 3:
        return
    height, width = pixels.shape
    wide, tall, middle_u, middle_v = lens
    top, bottom = _rows(outline, count, height)
    step = np.float32(plane[1] / wide)
    step0, step1 = np.float32(levels[0, 1] / wide), np.float32(levels[1, 1] / wide)
    step2, step3 = np.float32(levels[2, 1] / wide), np.float32(levels[3, 1] / wide)
    for row in range(top, bottom):
        first, end = _span(outline, count, row, width)
        if first >= end:
            continue
        y, z = (first + 0.5 - middle_u) / wide, (middle_v - row - 0.5) / tall
        start = np.float32(plane[0] + plane[1] * y + plane[2] * z)
        start0 = np.float32(levels[0, 0] + levels[0, 1] * y + levels[0, 2] * z)
        start1 = np.float32(levels[1, 0] + levels[1, 1] * y + levels[1, 2] * z)
        start2 = np.float32(levels[2, 0] + levels[2, 1] * y + levels[2, 2] * z)
        start3 = np.float32(levels[3, 0] + levels[3, 1] * y + levels[3, 2] * z)
        near, into = nearness[row, first:end], pixels[row, first:end]
        if is_solid and tests_depth:
            for k in range(end - first):
                along = np.float32(k)
                here = start + along * step
                away = _ONE / here
                shade = (
                    _OPAQUE
                    | _byte((start0 + along * step0) * away)
                    | _byte((start1 + along * step1) * away) << _SECOND
                    | _byte((start2 + along * step2) * away) << _THIRD
                )
                is_nearer = here > near[k]
                near[k] = here if is_nearer else near[k]
                into[k] = shade if is_nearer else into[k]
            continue
        for k in range(end - first):
            along = np.float32(k)
            here = start + along * step
            if not tests_depth or here > near[k]:
                away = _ONE / here
                if tests_depth:
                    near[k] = here
                shade = (
                    _byte((start0 + along * step0) * away)
                    | _byte((start1 + along * step1) * away) << _SECOND
                    | _byte((start2 + along * step2) * away) << _THIRD
                    | _byte((start3 + along * step3) * away) << _ALPHA
                )
                into[k] = _blended(into[k], shade, adds)


@compiled
def _byte(value: Any) -> Any:
    return np.uint32(np.int32(min(max(value + _HALF, _ZERO), _MOST)))


@compiled
def _blended(below: Any, shade: Any, adds: bool) -> Any:
    """Return `shade` blended into the pixel below by its alpha, or added to it as light: d + s (1 - d)."""
    alpha = shade >> _ALPHA
    result = numba.uint32(0)
    for byte in range(4):
        by = numba.uint32(8 * byte)
        new, old = shade >> by & _BYTE, below >> by & _BYTE
        if adds:
            value = old + (new * (_BYTE - old) + numba.uint32(127)) // _BYTE
        else:
            value = (new * alpha + old * (_BYTE - alpha) + numba.uint32(127)) // _BYTE
        result |= numba.uint32(value) << by
    return numba.uint32(result)


_MASK, _BYTE_BITS, _QUARTER = numba.uint32(0x00FF00FF), numba.uint32(8), numba.uint32(2)


def halved(samples: Pixels) -> Pixels:
    """Return the averages, rounded down, of each byte of two by two samples; (2 h, 2 w) becomes (h, w)."""
    picture = np.empty((samples.shape[0] // 2, samples.shape[1] // 2), np.uint32)
    _halve(samples, picture)
    return picture


@compiled
def _halve(samples: Pixels, picture: Pixels) -> None:
    for y in range(picture.shape[0]):
        upper, lower, row = samples[2 * y], samples[2 * y + 1], picture[y]
        for x in range(len(row)):
            a, b, c, d = upper[2 * x], upper[2 * x + 1], lower[2 * x], lower[2 * x + 1]
            even = (a & _MASK) + (b & _MASK) + (c & _MASK) + (d & _MASK)
            odd = (
                ((a >> _BYTE_BITS) & _MASK)
                + ((b >> _BYTE_BITS) & _MASK)
                + ((c >> _BYTE_BITS) & _MASK)
                + ((d >> _BYTE_BITS) & _MASK)
            )
            row[x] = ((even >> _QUARTER) & _MASK) | (((odd >> _QUARTER) & _MASK) << _BYTE_BITS)
