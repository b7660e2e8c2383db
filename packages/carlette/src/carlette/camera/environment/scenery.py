"""Houses, trees, hedges and street lamps along the roads: generated, but always the same for the same map.

They are not in the map, take no part in the physics, and are never placed on a lane.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from random import Random
from typing import Any

import numpy as np
import shapely

from carlette.camera.environment.road_surface import Pavement
from carlette.camera.environment.sampled_roads import SampledRoad
from carlette.camera.models.mesh import Builder, Color, Mesh, Point, mix, shade
from carlette.camera.rendering import tags
from carlette.geometry import Floats

PLOT_M = 17.0
"""Distance between plots (m). Ours."""
LAMP_EVERY_M = 32.0
"""Distance between street lamps (m). Ours."""
CLEARANCE_M = 1.5
"""Clearance around a plot (m). Ours."""
WALLS: tuple[Color, ...] = (
    (196, 176, 150), (170, 96, 78), (204, 198, 188), (150, 140, 130), (214, 188, 140), (128, 142, 156), (186, 150, 120),
)  # fmt: skip
ROOFS: tuple[Color, ...] = ((138, 70, 56), (92, 88, 90), (120, 92, 70))
GREENS: tuple[Color, ...] = ((66, 112, 52), (84, 128, 56), (54, 98, 60), (100, 132, 62))
GLASS: Color = (70, 88, 104)
LAMPLIGHT: Color = (255, 226, 160)
_COUNTRY = ("rural", "motorway", "lowSpeed")


@dataclass(frozen=True)
class Item:
    """One object at the roadside."""

    base: Mesh
    """The mesh that is visible from a distance."""
    detail: Mesh
    """The mesh that is drawn only at close range."""
    night: Mesh
    """The mesh that is drawn in the dark: lit windows and lamps."""
    place: tuple[float, float]
    radius_m: float


def scenery(pavement: Pavement, seed: int, taken: list[tuple[float, float]]) -> list[Item]:
    """Return all objects at the roadsides. `taken` are positions of posts that must stay visible (m)."""
    lanes = shapely.polygons(np.concatenate(pavement.lanes))
    tree = shapely.STRtree(lanes)
    sites = _Sites(tree, taken)
    made: list[Item] = []
    for number, (road, points, outward) in enumerate(pavement.edges):
        random = Random(f"{seed}:{road.id}:{number}")
        if not road.junction:
            made.extend(_lamps(road, points, outward, random))
        made.extend(_plots(road, points, outward, random, sites))
    return made


class _Sites:
    """The plots that are already occupied."""

    def __init__(self, lanes: Any, posts: list[tuple[float, float]]) -> None:
        self._lanes = lanes
        self._cells: dict[tuple[int, int], list[Any]] = {}
        for x, y in posts:
            self._book(shapely.Point(x, y).buffer(2.5))

    def claim(self, corners: Floats) -> bool:
        """Claim a plot; False if it overlaps a lane or another plot."""
        plot = shapely.Polygon(corners)
        wide = plot.buffer(CLEARANCE_M)
        if len(self._lanes.query(wide, predicate="intersects")):
            return False
        if any(plot.intersects(cell) for key in self._keys(plot) for cell in self._cells.get(key, ())):
            return False
        self._book(plot)
        return True

    def _book(self, plot: Any) -> None:
        for key in self._keys(plot):
            self._cells.setdefault(key, []).append(plot)

    @staticmethod
    def _keys(plot: Any) -> list[tuple[int, int]]:
        low_x, low_y, high_x, high_y = (math.floor(bound / 40.0) for bound in plot.bounds)
        return [(x, y) for x in range(low_x, high_x + 1) for y in range(low_y, high_y + 1)]


def _along(points: Floats, outward: Floats, step_m: float, start_m: float) -> Iterator[tuple[Floats, Floats]]:
    """Yield points every `step_m` along a border, with the direction away from the road."""
    lengths = np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1)
    total = np.concatenate([[0.0], np.cumsum(lengths)])
    for at in np.arange(start_m, total[-1], step_m):
        index = min(int(np.searchsorted(total, at, side="right")) - 1, len(lengths) - 1)
        share = (at - total[index]) / max(lengths[index], 1e-9)
        yield points[index] + share * (points[index + 1] - points[index]), outward[index]


def _lamps(road: SampledRoad, points: Floats, outward: Floats, random: Random) -> Iterator[Item]:
    if road.kind in ("rural", "motorway") or road.length < 20.0:
        return
    for place, away in _along(points, outward, LAMP_EVERY_M, random.uniform(6.0, 16.0)):
        x, y = place[:2] + 0.35 * away
        yaw = math.atan2(-away[1], -away[0])
        pole, shine = _lamp()
        yield Item(
            pole.placed(x, y, float(place[2]), yaw),
            EMPTY_MESH,
            shine.placed(x, y, float(place[2]), yaw),
            (float(x), float(y)),
            3.0,
        )


def _plots(road: SampledRoad, points: Floats, outward: Floats, random: Random, sites: _Sites) -> Iterator[Item]:
    is_country = road.kind in _COUNTRY
    for place, away in _along(points, outward, PLOT_M, random.uniform(2.0, PLOT_M)):
        choice = random.random()
        if choice < (0.04 if is_country else 0.52):
            item = _house(place, away, random, sites)
            if item is not None:
                yield item
                continue
        for _ in range(random.randint(1, 3)):
            item = _plant(place, away, random, sites)
            if item is not None:
                yield item


def _house(place: Floats, away: Floats, random: Random, sites: _Sites) -> Item | None:
    width, depth = random.uniform(10.0, 15.5), random.uniform(8.0, 12.0)
    back = random.uniform(3.0, 6.0)
    aside = np.array([-away[1], away[0]])
    middle = place[:2] + away * (back + depth / 2)
    corners = np.array([middle + aside * a * width / 2 + away * b * depth / 2 for a, b in _RING])
    if not sites.claim(corners):
        return None
    yaw = math.atan2(-away[1], -away[0])
    floors = random.choice((1, 2, 2, 3, 4, 5, 6))
    base, detail, night = _building(width, depth, floors, random)
    at = (float(middle[0]), float(middle[1]), float(place[2]) - 0.4)
    return Item(
        base.placed(*at, yaw), detail.placed(*at, yaw), night.placed(*at, yaw), at[:2], math.hypot(width, depth) / 2
    )


def _building(width: float, depth: float, floors: int, random: Random) -> tuple[Mesh, Mesh, Mesh]:
    """Return a house whose front looks along +x: walls and roof, windows, lit windows."""
    wall, height = random.choice(WALLS), 1.0 + 3.1 * floors
    base, detail, night = Builder(tags.BUILDING), Builder(tags.BUILDING), Builder(tags.BUILDING)
    hx, hy = depth / 2, width / 2
    low: list[Point] = [(a * hx, b * hy, 0.0) for a, b in _RING]
    high: list[Point] = [(a * hx, b * hy, height) for a, b in _RING]
    base.hull(low, high, wall)
    roof = random.choice(ROOFS)
    if floors <= 3:
        eaves: list[Point] = [(a * (hx + 0.5), b * (hy + 0.4), height - 0.1) for a, b in _RING]
        ridge: list[Point] = [(0.02 * a, b * (hy + 0.4), height + 0.36 * depth) for a, b in _RING]
        base.hull(eaves, ridge, roof)
    else:
        base.box((0, 0, height + 0.2), (depth + 0.4, width + 0.4, 0.4), shade(wall, 0.72))
        base.box((-1.0, 1.0, height + 1.2), (2.5, 3.0, 1.8), shade(wall, 0.85))
    base.box((hx + 0.03, 0, 0.35), (0.1, width, 0.7), shade(wall, 0.6))
    shop = floors >= 3 and random.random() < 0.6
    for front, half, span in ((0, hx, width), (1, hy, depth), (2, hy, depth)):
        count = max(2, int(span / 2.9))
        for floor in range(floors):
            for column in range(count):
                y = (column + 0.5) / count * span - span / 2
                z = 0.4 + 1.0 + 3.1 * floor + 0.85
                is_shop = shop and floor == 0 and front == 0
                size = (span / count * 0.86, 2.2) if is_shop else (1.35, 1.55)
                lit = random.random() < 0.35
                _window(detail, front, half + 0.03, (y, z - 0.25 * is_shop), size, GLASS, glow=False)
                if lit:
                    _window(night, front, half + 0.05, (y, z - 0.25 * is_shop), size, LAMPLIGHT, glow=True)
    _window(detail, 0, hx + 0.05, (hy * 0.1, 1.35), (1.1, 2.2), shade(roof, 0.7), glow=False)
    return base.mesh(), detail.mesh(), night.mesh()


def _window(
    builder: Builder,
    front: int,
    half: float,
    at: tuple[float, float],
    size: tuple[float, float],
    color: Color,
    *,
    glow: bool,
) -> None:
    """Build a pane in the front (0) or one of the gables (1, 2)."""
    (across, z), (w, h) = at, (size[0] / 2, size[1] / 2)
    flat = [(across - w, z - h), (across + w, z - h), (across + w, z + h), (across - w, z + h)]
    if front == 0:
        builder.face([(half, y, up) for y, up in flat], color, (1.0, 0.0, 0.0), glow=glow)
    else:
        side = 1.0 if front == 1 else -1.0
        builder.face([(y, side * half, up) for y, up in flat], color, (0.0, side, 0.0), glow=glow)


def _plant(place: Floats, away: Floats, random: Random, sites: _Sites) -> Item | None:
    aside = np.array([-away[1], away[0]])
    middle = place[:2] + away * random.uniform(2.5, 11.0) + aside * random.uniform(-6.0, 6.0)
    size = random.uniform(0.7, 1.3)
    kind = random.choice(("broad", "broad", "conifer", "bush"))
    half = 0.9 if kind == "bush" else 1.6 * size
    corners = np.array([middle + np.array([a, b]) * half for a, b in _RING])
    if not sites.claim(corners):
        return None
    mesh = _tree(kind, random.randrange(len(GREENS))).placed(
        float(middle[0]), float(middle[1]), float(place[2]) - 0.35, random.uniform(0, 6.28), size
    )
    return Item(mesh, EMPTY_MESH, EMPTY_MESH, (float(middle[0]), float(middle[1])), half * 1.5)


@lru_cache(maxsize=32)
def _tree(kind: str, green: int) -> Mesh:
    builder, leaf = Builder(tags.VEGETATION), GREENS[green]
    if kind == "bush":
        builder.cylinder((0, 0, 0), (0, 0, 0.7), 0.8, shade(leaf, 0.85), sides=6, tip=1.0)
        builder.cylinder((0, 0, 0.7), (0, 0, 1.4), 1.0, leaf, sides=6, tip=0.4)
        return builder.mesh()
    builder.cylinder((0, 0, 0), (0, 0, 2.4), 0.2, (104, 80, 58), sides=5, tip=0.14)
    if kind == "conifer":
        for low, high, radius in ((1.3, 4.4, 1.9), (3.2, 6.4, 1.45), (5.2, 8.4, 1.0)):
            builder.cylinder(
                (0, 0, low), (0, 0, high), radius, mix(shade(leaf, 0.7), (40, 84, 60), 0.5), sides=6, tip=0
            )
        return builder.mesh()
    levels = ((1.9, 0.9), (2.9, 2.05), (4.4, 2.3), (5.8, 1.7), (6.6, 0.6))
    for number, ((z0, r0), (z1, r1)) in enumerate(itertools.pairwise(levels)):
        builder.cylinder((0, 0, z0), (0, 0, z1), r0, shade(leaf, 0.8 + 0.09 * number), sides=7, tip=r1)
    return builder.mesh()


@lru_cache(maxsize=1)
def _lamp() -> tuple[Mesh, Mesh]:
    """Return a street lamp whose arm reaches along +x, and its light with the pool on the road."""
    builder, shine = Builder(tags.POLE), Builder(tags.POLE)
    builder.cylinder((0, 0, 0), (0, 0, 6.6), 0.09, (112, 116, 120), sides=5, tip=0.06)
    builder.limb((0, 0, 6.5), (1.7, 0, 6.8), 0.08, 0.08, (112, 116, 120))
    builder.box((1.9, 0, 6.78), (0.7, 0.26, 0.12), (90, 94, 98))
    shine.box((1.9, 0, 6.70), (0.66, 0.28, 0.08), LAMPLIGHT, glow=True)
    ring = [(2.0 + 7.0 * math.cos(math.pi * a / 6), 7.0 * math.sin(math.pi * a / 6), 0.2) for a in range(12)]
    shine.spot((2.0, 0.0, 0.2), ring, LAMPLIGHT, (0.0, 0.0, 1.0), 130)
    return builder.mesh(), shine.mesh()


_RING = ((1, 1), (1, -1), (-1, -1), (-1, 1))
EMPTY_MESH = Builder().mesh()
