"""The static part of a map, in chunks that are drawn or skipped as a whole."""

from __future__ import annotations

import math
import zlib
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from carlette.camera.arrays import Bytes
from carlette.camera.environment import road_furniture
from carlette.camera.environment.junction_surface import fill_gaps
from carlette.camera.environment.repeater_lights import repeaters_of
from carlette.camera.environment.road_surface import Pavement, pave, upward
from carlette.camera.environment.sampled_roads import read_roads
from carlette.camera.environment.scenery import Item, scenery
from carlette.camera.models.mesh import EMPTY, Mesh, corner_colors, quads
from carlette.camera.rendering import tags
from carlette.camera.rendering.lighting import Light
from carlette.geometry import Floats, Vector
from carlette.opendrive.map_file import check_opendrive
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.signals import LIGHT_TYPE, Signal, read_signals

CHUNK_M = 48.0
"""Edge of a chunk (m). Ours."""
TERRAIN_M = 12.0
"""Edge of a terrain square (m). Ours."""
BORDER_M = 260.0
"""Extent of the terrain beyond the outermost lanes (m). Ours."""
UNDER_ROAD_M = 0.12
"""Height of the terrain below the nearest road (m). Ours."""
MEADOW = (112, 138, 74)
SOLID, PAINT, DETAIL, NIGHT, WATER = "solid", "paint", "detail", "night", "water"
LAYERS = (PAINT, DETAIL, SOLID, NIGHT, WATER)
"""Layers in the order of drawing.

Markings precede the floor below them, because hidden pixels cost less. Night and water are translucent and come last.
"""


@dataclass
class Chunk:
    """The static objects of one square of the map."""

    center: tuple[float, float, float]
    radius_m: float
    layers: dict[str, Mesh]
    _lit: dict[str, tuple[Light, Bytes]] = field(default_factory=dict)
    _faded: dict[str, tuple[float, Bytes]] = field(default_factory=dict)

    def colors(self, layer: str, light: Light) -> Bytes:
        """Return the colors (B G R A) of a layer's corners in this light, (n, 4, 4).

        They are cached until the light changes.
        """
        cached = self._lit.get(layer)
        if cached is None or cached[0] is not light:
            mesh = self.layers[layer]
            shown = light.lit(mesh.normals, mesh.colors, mesh.glow, mesh.tags)
            cached = self._lit[layer] = (light, corner_colors(mesh, shown, adds=layer == NIGHT))
            self._faded.pop(layer, None)
        return cached[1]

    def faded(self, layer: str, light: Light, share: float) -> Bytes:
        """Return the same colors with this share of the haze's color. The last result is cached."""
        colors = self.colors(layer, light)
        cached = self._faded.get(layer)
        if cached is None or cached[0] != share:
            haze = np.array([light.fog[2], light.fog[1], light.fog[0], 255], np.float32)
            faded = (colors + (haze - colors) * np.float32(share)).astype(np.uint8)
            cached = self._faded[layer] = (share, faded)
        return cached[1]


@dataclass(frozen=True)
class StaticScene:
    """The static scene of one map."""

    chunks: list[Chunk]
    centers: Floats
    """(n, 3) centers of the chunks."""
    radii: Floats


def build_static_scene(network: RoadNetwork) -> StaticScene:
    """Return all static meshes of a map; always the same for the same map."""
    root = check_opendrive(network.file.text, network.file.name)
    roads = read_roads(root)
    pavement = pave(roads)
    signals = read_signals(network, root)
    posts = road_furniture.signs(root, roads, signals)
    paint = [*pavement.paint, *road_furniture.crosswalks(network), *road_furniture.stop_lines(signals)]
    paint += road_furniture.stencils(root, roads)
    taken = [(float(place[0]), float(place[1])) for _, place in posts]
    taken += [(signal.pose.location.x, signal.pose.location.y) for signal in signals]
    taken += _repeaters(network, signals)
    items = scenery(pavement, zlib.crc32(network.file.text.encode("utf-8", "surrogateescape")), taken)
    cells = _Cells()
    cells.spread(SOLID, [*pavement.floor, *fill_gaps(pavement), _terrain(pavement)])
    cells.spread(PAINT, paint)
    cells.spread(WATER, [_puddles(pavement)])
    for mesh, place in posts:
        cells.add_mesh(SOLID, mesh, (float(place[0]), float(place[1])))
    for item in items:
        _put_item(cells, item)
    chunks = cells.chunks()
    return StaticScene(
        chunks,
        np.array([chunk.center for chunk in chunks], float),
        np.array([chunk.radius_m for chunk in chunks], float),
    )


def _repeaters(network: RoadNetwork, signals: list[Signal]) -> list[tuple[float, float]]:
    lights = [signal for signal in signals if signal.type == LIGHT_TYPE]
    pairs = zip(lights, repeaters_of(network), strict=True)
    feet = [light.pose.apply(Vector(*foot)) for light, foot in pairs if foot is not None]
    return [(item.x, item.y) for item in feet]


def _put_item(cells: _Cells, item: Item) -> None:
    cells.add_mesh(SOLID, item.base, item.place)
    cells.add_mesh(DETAIL, item.detail, item.place)
    cells.add_mesh(NIGHT, item.night, item.place)


class _Cells:
    """Meshes by square and layer."""

    def __init__(self) -> None:
        self._meshes: dict[tuple[int, int], dict[str, list[Mesh]]] = defaultdict(lambda: defaultdict(list))

    def add_mesh(self, layer: str, mesh: Mesh, place: tuple[float, float]) -> None:
        if len(mesh):
            key = (math.floor(place[0] / CHUNK_M), math.floor(place[1] / CHUNK_M))
            self._meshes[key][layer].append(mesh)

    def spread(self, layer: str, meshes: Iterable[Mesh]) -> None:
        """Assign each quad to the square that contains it."""
        every = Mesh.join(list(meshes))
        keys = np.floor(every.corners[:, :, :2].mean(axis=1) / CHUNK_M).astype(np.int64)
        if not len(keys):
            return
        order = np.lexsort((keys[:, 1], keys[:, 0]))
        ordered = keys[order]
        cuts = np.flatnonzero((np.diff(ordered, axis=0) != 0).any(axis=1)) + 1
        for part in np.split(order, cuts):
            x, y = keys[part[0]].tolist()
            self._meshes[x, y][layer].append(every.take(part))

    def chunks(self) -> list[Chunk]:
        """Return the scene's parts, each with its layers joined and its bounds."""
        made = []
        for key in sorted(self._meshes):
            layers = {name: Mesh.join(parts) for name, parts in self._meshes[key].items()}
            corners = np.concatenate([mesh.corners.reshape(-1, 3) for mesh in layers.values()])
            low, high = corners.min(axis=0).astype(float), corners.max(axis=0).astype(float)
            middle = (low + high) / 2
            center = (float(middle[0]), float(middle[1]), float(middle[2]))
            made.append(Chunk(center, float(np.linalg.norm(high - low)) / 2, layers))
        return made


def _terrain(pavement: Pavement) -> Mesh:
    """Return a meadow everywhere, a little below the nearest road."""
    corners = np.concatenate([points for _, points, _ in pavement.edges])
    lanes = np.concatenate(pavement.lanes).mean(axis=1)
    low, high = lanes.min(axis=0) - BORDER_M, lanes.max(axis=0) + BORDER_M
    xs = np.arange(low[0], high[0] + TERRAIN_M, TERRAIN_M)
    ys = np.arange(low[1], high[1] + TERRAIN_M, TERRAIN_M)
    if np.ptp(corners[:, 2]) < 0.05:
        step = 4  # flat: large squares suffice
        xs, ys = xs[::step], ys[::step]
        heights = np.full((len(xs), len(ys)), corners[:, 2].min() - UNDER_ROAD_M)
    else:
        heights = _heights(xs, ys, corners)
    grid = np.stack([*np.meshgrid(xs, ys, indexing="ij"), heights], axis=-1)
    strip = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2).reshape(-1, 4, 3)
    mesh = quads(upward(strip), MEADOW, tags.TERRAIN)
    spots = np.random.default_rng(7).integers(-7, 8, (len(mesh), 1))
    mesh.colors[:, :3] = np.clip(mesh.colors[:, :3].astype(int) + spots, 0, 255)
    return mesh


def _heights(xs: Floats, ys: Floats, roadside: Floats) -> Floats:
    """Return the lowest roadside near each knot.

    Knots without one get the height of the knots around, smoothed outward.
    """
    heights = np.full((len(xs), len(ys)), np.inf)
    column = np.rint((roadside[:, 0] - xs[0]) / TERRAIN_M).astype(int)
    row = np.rint((roadside[:, 1] - ys[0]) / TERRAIN_M).astype(int)
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            x, y = np.clip(column + dx, 0, len(xs) - 1), np.clip(row + dy, 0, len(ys) - 1)
            np.minimum.at(heights, (x, y), roadside[:, 2] - UNDER_ROAD_M - 0.25)
    known = np.isfinite(heights)
    filled = np.where(known, heights, 0.0)
    weight = known.astype(float)
    for _ in range(64):
        if (weight > 0).all():
            break
        padded, heavy = np.pad(filled * (weight > 0), 1), np.pad((weight > 0).astype(float), 1)
        total = sum(padded[1 + a : len(xs) + 1 + a, 1 + b : len(ys) + 1 + b] for a, b in _AROUND)
        count = sum(heavy[1 + a : len(xs) + 1 + a, 1 + b : len(ys) + 1 + b] for a, b in _AROUND)
        new = (weight == 0) & (count > 0)
        filled[new], weight[new] = (total / np.maximum(count, 1))[new], 1.0
    filled[weight == 0] = float(np.median(heights[known]))
    return filled


_AROUND = ((-1, 0), (1, 0), (0, -1), (0, 1))


def _puddles(pavement: Pavement) -> Mesh:
    """Return positions where water can collect. The alpha of each is the wetness from which it is shown."""
    lanes = np.concatenate(pavement.driving) if pavement.driving else np.zeros((0, 4, 2))
    floor = [item for item in pavement.floor if len(item) and item.tags[0] == tags.ROAD and item.colors[0, 0] < 100]
    random = np.random.default_rng(11)
    every = Mesh.join(floor).corners.astype(float)
    if not len(lanes) or not len(every):
        return EMPTY
    chosen = every[random.random(len(every)) < 0.5]
    part = random.uniform(0.2, 0.8, (len(chosen), 2))
    a, b, c, d = (chosen[:, i] for i in range(4))
    u, v = part[:, :1], part[:, 1:]
    middle = (a * (1 - u) + b * u) * (1 - v) + (d * (1 - u) + c * u) * v
    turns = np.linspace(0.0, 2 * math.pi, 9)[:-1]
    radius = random.uniform(0.5, 1.0, (len(chosen), 8, 1)) * random.uniform(0.4, 1.3, (len(chosen), 1, 1))
    ring = middle[:, None, :] + radius * np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
    ring[..., 2] = middle[:, None, 2] + 0.012
    pieces = np.concatenate([ring[:, [0, 1, 2, 3]], ring[:, [0, 3, 4, 5]], ring[:, [0, 5, 6, 7]]])
    mesh = quads(upward(pieces), (255, 255, 255), tags.ROAD)
    rank = random.integers(1, 101, len(chosen))
    mesh.colors[:, 3] = np.tile(rank, 3)
    return mesh
