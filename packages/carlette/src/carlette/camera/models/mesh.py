"""Meshes of flat-colored quads, and a builder for them.

Frames are CARLA's: x ahead, y right, z up, meters. A triangle is a quad whose last two corners are the same.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from carlette.camera.arrays import Bytes, Singles

Color = tuple[int, int, int]
Point = tuple[float, float, float]


@dataclass(frozen=True)
class Mesh:
    """`n` quads: the constant part of an object's appearance."""

    corners: Singles
    """(n, 4, 3) meters; (b - a) x (d - a) points outward."""
    normals: Singles
    """(n, 3), unit length."""
    colors: Bytes
    """(n, 4): red, green, blue, alpha."""
    glow: NDArray[np.bool_]
    """(n,): True if it emits light, independently of the lighting."""
    tags: Bytes
    """(n,): semantic tag (`CityObjectLabel`)."""
    fade: Bytes | None = None
    """(n, 4): alpha of each corner if it varies across a quad; None if the color's alpha applies everywhere."""

    def __len__(self) -> int:
        return len(self.corners)

    @staticmethod
    def join(parts: Sequence[Mesh]) -> Mesh:
        """Return all quads of several meshes."""
        if not parts:
            return EMPTY
        return Mesh(
            np.ascontiguousarray(np.concatenate([part.corners for part in parts])),
            np.concatenate([part.normals for part in parts]),
            np.concatenate([part.colors for part in parts]),
            np.concatenate([part.glow for part in parts]),
            np.concatenate([part.tags for part in parts]),
            np.concatenate([part.corner_alphas() for part in parts])
            if any(part.fade is not None for part in parts)
            else None,
        )

    def corner_alphas(self) -> Bytes:
        """(n, 4): alpha of each corner."""
        return np.repeat(self.colors[:, 3:], 4, axis=1) if self.fade is None else self.fade

    def take(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> Mesh:
        """Return some of the quads."""
        return Mesh(
            np.ascontiguousarray(self.corners[which]),
            self.normals[which],
            self.colors[which],
            self.glow[which],
            self.tags[which],
            None if self.fade is None else self.fade[which],
        )

    def placed(self, x: float, y: float, z: float, yaw_rad: float = 0.0, scale: float = 1.0) -> Mesh:
        """Return the mesh moved (m), turned and scaled."""
        cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]], np.float32)
        corners = self.corners @ (turn * np.float32(scale)) + np.array([x, y, z], np.float32)
        return Mesh(corners.astype(np.float32), self.normals @ turn, self.colors, self.glow, self.tags, self.fade)


def quads(corners: ArrayLike, color: Color, tag: int = 0, *, glow: bool = False, alpha: int = 255) -> Mesh:
    """Return quads of one color; `corners` is (n, 4, 3)."""
    points: Singles = np.ascontiguousarray(corners, np.float32).reshape(-1, 4, 3)
    count = len(points)
    return Mesh(
        points,
        normals_of(points),
        np.tile(np.array([*color, alpha], np.uint8), (count, 1)),
        np.full(count, glow),
        np.full(count, tag, np.uint8),
    )


def corner_colors(mesh: Mesh, lit: Bytes, *, adds: bool = False) -> Bytes:
    """Return R G B A of quads (n, 4) as B G R A of their corners (n, 4, 4).

    With `adds` they are light that is added to a picture: scaled by their alpha, and opaque.
    """
    corners = np.repeat(lit[:, None, [2, 1, 0, 3]], 4, axis=1)
    if mesh.fade is not None:
        corners[..., 3] = mesh.fade
    if adds:
        corners[..., :3] = corners[..., :3].astype(np.uint16) * corners[..., 3:] // 255
        corners[..., 3] = 255
    return corners


def normals_of(corners: Singles) -> Singles:
    """Return unit normals of quads (by their diagonals, so triangles count too)."""
    (ux, uy, uz), (vx, vy, vz) = (corners[:, 2] - corners[:, 0]).T, (corners[:, 3] - corners[:, 1]).T
    # `np.cross` is several times slower for the thousands of small meshes of a map.
    cross = np.empty((len(corners), 3), np.float32)
    cross[:, 0], cross[:, 1], cross[:, 2] = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    cross /= np.maximum(np.sqrt(np.einsum("ij,ij->i", cross, cross)), np.float32(1e-12))[:, None]
    return cross


EMPTY = quads(np.zeros((0, 4, 3)), (0, 0, 0))


class Builder:
    """Builds meshes from shapes. Faces of solid shapes point away from the shape's center."""

    def __init__(self, tag: int = 0) -> None:
        self.tag = tag
        self._corners: list[Sequence[Point]] = []
        self._colors: list[tuple[int, int, int, int]] = []
        self._glow: list[bool] = []
        self._tags: list[int] = []
        self._fade: dict[int, tuple[int, int, int, int]] = {}

    def mesh(self) -> Mesh:
        """Return the mesh that was built."""
        if not self._corners:
            return EMPTY
        corners: Singles = np.array(self._corners, np.float32)
        return Mesh(
            corners,
            normals_of(corners),
            np.array(self._colors, np.uint8),
            np.array(self._glow, bool),
            np.array(self._tags, np.uint8),
            self._alphas() if self._fade else None,
        )

    def _alphas(self) -> Bytes:
        alphas = np.repeat(np.array(self._colors, np.uint8)[:, 3:], 4, axis=1)
        for index, values in self._fade.items():
            alphas[index] = values
        return alphas

    def glowing(self, points: Sequence[Point], color: Color, towards: Point, alphas: Sequence[int]) -> None:
        """Add a translucent, luminous face of three or four corners, each with its own alpha."""
        index = len(self._corners)
        self.face(points, color, towards, glow=True)
        values = dict(zip(points, alphas, strict=True))
        placed = [values[corner] for corner in self._corners[index]]
        self._fade[index] = (placed[0], placed[1], placed[2], placed[3])

    def spot(
        self, center: Point, ring: Sequence[Point], color: Color, towards: Point, alpha: int, rim: int = 0
    ) -> None:
        """Add light or shade that fades from `center` to the `ring` around it."""
        for item, other in zip(ring, [*ring[1:], ring[0]], strict=True):
            self.glowing([center, item, other], color, towards, [alpha, rim, rim])

    def face(
        self, points: Sequence[Point], color: Color, towards: Point, *, glow: bool = False, alpha: int = 255
    ) -> None:
        """One flat face of three or more corners, its front on the side of the direction `towards`."""
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = points[0], points[1], points[2]
        ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        side = (uy * vz - uz * vy) * towards[0] + (uz * vx - ux * vz) * towards[1] + (ux * vy - uy * vx) * towards[2]
        ordered = list(points) if side >= 0 else list(reversed(points))
        for index in range(1, len(ordered) - 1, 2):
            last = ordered[min(index + 2, len(ordered) - 1)]
            self._corners.append((ordered[0], ordered[index], ordered[index + 1], last))
            self._colors.append((*color, alpha))
            self._glow.append(glow)
            self._tags.append(self.tag)

    def hull(self, low: Sequence[Point], high: Sequence[Point], color: Color, top: Color | None = None) -> None:
        """A convex body between two rings of corners of the same number, both in the same sense of rotation."""
        middle = _middle([*low, *high])
        count = len(low)
        for index in range(count):
            after = (index + 1) % count
            ring = (low[index], low[after], high[after], high[index])
            self.face(_distinct(ring), color, _away(_middle(ring), middle))
        self.face(low, color, _away(_middle(low), middle))
        self.face(high, top or color, _away(_middle(high), middle))

    def box(self, center: Point, size: Point, color: Color, yaw_deg: float = 0.0, *, glow: bool = False) -> None:
        """A box of full `size`, turned about the vertical through its middle."""
        (cx, cy, cz), (hx, hy, hz) = center, (size[0] / 2, size[1] / 2, size[2] / 2)
        cos, sin = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
        ring = [
            (cx + x * hx * cos - y * hy * sin, cy + x * hx * sin + y * hy * cos)
            for x, y in ((1, 1), (1, -1), (-1, -1), (-1, 1))
        ]
        low = [(x, y, cz - hz) for x, y in ring]
        high = [(x, y, cz + hz) for x, y in ring]
        start = len(self._glow)
        self.hull(low, high, color)
        self._glow[start:] = [glow] * (len(self._glow) - start)

    def cylinder(
        self,
        low: Point,
        high: Point,
        radius: float,
        color: Color,
        *,
        sides: int = 8,
        tip: float | None = None,
        cap: Color | None = None,
    ) -> None:
        """A round body about the line from `low` to `high`; `tip` is the radius at `high`, the same if None."""
        axis = np.subtract(high, low)
        axis = axis / np.linalg.norm(axis)
        aside = np.cross(axis, (0.0, 0.0, 1.0) if abs(axis[2]) < 0.9 else (1.0, 0.0, 0.0))
        aside /= np.linalg.norm(aside)
        other = np.cross(axis, aside)
        end = radius if tip is None else tip
        rings: list[list[Point]] = []
        for place, r in ((low, radius), (high, max(end, 1e-4))):
            turns = (2 * math.pi * (side + 0.5) / sides for side in range(sides))
            ring = [np.add(place, r * (math.cos(a) * aside + math.sin(a) * other)) for a in turns]
            rings.append([(float(p[0]), float(p[1]), float(p[2])) for p in ring])
        start = len(self._colors)
        self.hull(rings[0], rings[1], color)
        if cap is not None:
            caps = math.ceil((sides - 2) / 2) * 2
            self._colors[max(start, len(self._colors) - caps) :] = [(*cap, 255)] * caps

    def loft(self, stations: Sequence[tuple[float, float, float, float, float]], color: Color, y: float = 0.0) -> None:
        """A body along x, mirrored about `y`: stations (x, low z, high z, half width below, above), open below."""
        for station, other in itertools.pairwise(stations):
            (x0, l0, h0, b0, a0), (x1, l1, h1, b1, a1) = station, other
            for side in (1.0, -1.0):
                wall = (
                    (x0, y + side * b0, l0),
                    (x1, y + side * b1, l1),
                    (x1, y + side * a1, h1),
                    (x0, y + side * a0, h0),
                )
                self.face(wall, color, (0.0, side, 0.1))
            self.face(((x0, y - a0, h0), (x0, y + a0, h0), (x1, y + a1, h1), (x1, y - a1, h1)), color, (0.0, 0.0, 1.0))
        for (x, low, high, below, above), side in ((stations[0], -1.0), (stations[-1], 1.0)):
            side = side if stations[-1][0] > stations[0][0] else -side
            ring = ((x, y - below, low), (x, y + below, low), (x, y + above, high), (x, y - above, high))
            self.face(ring, color, (side, 0.0, 0.0))

    def disc(
        self,
        center: Point,
        radius: float,
        towards: Point,
        color: Color,
        *,
        sides: int = 10,
        glow: bool = False,
        alpha: int = 255,
    ) -> None:
        """A flat round face across x (`towards` along x) or across y."""
        turns = [2 * math.pi * side / sides for side in range(sides)]
        (x, y, z), r = center, radius
        if abs(towards[0]) > abs(towards[1]):
            ring = [(x, y + r * math.cos(a), z + r * math.sin(a)) for a in turns]
        else:
            ring = [(x + r * math.cos(a), y, z + r * math.sin(a)) for a in turns]
        self.face(ring, color, towards, glow=glow, alpha=alpha)

    def plate(
        self,
        center: Point,
        size: tuple[float, float],
        towards: Point,
        color: Color,
        *,
        glow: bool = False,
        alpha: int = 255,
    ) -> None:
        """Add a rectangle of width and height, across x or across y, or flat (`towards` along z: x and y size)."""
        (x, y, z), (a, b) = center, (size[0] / 2, size[1] / 2)
        if abs(towards[2]) > 0.5:
            ring = [(x + a * i, y + b * j, z) for i, j in _SQUARE]
        elif abs(towards[0]) > abs(towards[1]):
            ring = [(x, y + a * i, z + b * j) for i, j in _SQUARE]
        else:
            ring = [(x + a * i, y, z + b * j) for i, j in _SQUARE]
        self.face(ring, color, towards, glow=glow, alpha=alpha)

    def limb(self, start: Point, end: Point, width: float, depth: float, color: Color) -> None:
        """Add a four-sided stick from joint to joint; `width` along y, `depth` along x at its ends."""
        low = [(start[0] + x * depth / 2, start[1] + y * width / 2, start[2]) for x, y in _SQUARE]
        high = [(end[0] + x * depth / 2, end[1] + y * width / 2, end[2]) for x, y in _SQUARE]
        if abs(start[2] - end[2]) < max(abs(start[0] - end[0]), abs(start[1] - end[1])):
            low = [(start[0], start[1] + y * width / 2, start[2] + x * depth / 2) for x, y in _SQUARE]
            high = [(end[0], end[1] + y * width / 2, end[2] + x * depth / 2) for x, y in _SQUARE]
            if abs(start[1] - end[1]) > abs(start[0] - end[0]):
                low = [(start[0] + y * width / 2, start[1], start[2] + x * depth / 2) for x, y in _SQUARE]
                high = [(end[0] + y * width / 2, end[1], end[2] + x * depth / 2) for x, y in _SQUARE]
        self.hull(low, high, color)

    def add(self, mesh: Mesh) -> None:
        """Add another mesh. Quads without a tag get this builder's."""
        self._corners.extend(tuple(corner) for corner in mesh.corners.tolist())
        self._colors.extend(tuple(color) for color in mesh.colors.tolist())
        self._glow.extend(mesh.glow.tolist())
        self._tags.extend(tag or self.tag for tag in mesh.tags.tolist())


_SQUARE = ((1, 1), (1, -1), (-1, -1), (-1, 1))


def shade(color: Color, factor: float) -> Color:
    """Return a darker or lighter color."""
    return (_byte(color[0] * factor), _byte(color[1] * factor), _byte(color[2] * factor))


def mix(first: Color, second: Color, share: float) -> Color:
    """Return a color between two others; `share` is that of the second."""
    return (
        _byte(first[0] + (second[0] - first[0]) * share),
        _byte(first[1] + (second[1] - first[1]) * share),
        _byte(first[2] + (second[2] - first[2]) * share),
    )


def _byte(value: float) -> int:
    return max(0, min(255, round(value)))


def _middle(points: Sequence[Point]) -> Point:
    count = len(points)
    return (sum(p[0] for p in points) / count, sum(p[1] for p in points) / count, sum(p[2] for p in points) / count)


def _away(place: Point, middle: Point) -> Point:
    return (place[0] - middle[0], place[1] - middle[1], place[2] - middle[2])


def _distinct(points: Iterable[Point]) -> list[Point]:
    return list(dict.fromkeys(points))
