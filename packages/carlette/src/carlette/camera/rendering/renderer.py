"""Draws a frame: the static scene, the actors' parts and the sky, as colors, depths, tags or ids."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from threading import Lock

import numpy as np

from carlette.camera.arrays import Bytes, Pixels, Singles
from carlette.camera.environment.static_scene import DETAIL, LAYERS, NIGHT, PAINT, SOLID, WATER, Chunk, StaticScene
from carlette.camera.models.mesh import Mesh, corner_colors
from carlette.camera.rendering import tags
from carlette.camera.rendering.lighting import Light
from carlette.camera.rendering.raster import Raster
from carlette.camera.rendering.sky import dome, fill_sky, rain_streaks
from carlette.camera.rendering.view import CameraView
from carlette.geometry import Floats

REACH_M = 420.0
"""Distance within which the static scene is drawn (m). Ours."""
DETAIL_M = 110.0
"""Distance within which details are drawn (m). Ours."""
PART_M = 300.0
"""Distance within which actors are drawn (m). Ours."""
SUPERSAMPLED_PIXELS = 700_000
"""Largest picture that is supersampled two by two (pixels). Larger ones use one sample per pixel. Ours."""
OPAQUE_AIR = 5.0
"""Optical depth of fog (distance times density) behind which nothing is visible. Ours."""
CLEAR_PER_M = 0.0015
"""Density of fog below which a chunk fades as a whole (1/m). Ours."""
KEPT_COLORS = 2048
"""Number of meshes whose lit colors are cached. Ours."""


@dataclass(frozen=True)
class RenderPart:
    """One rigid piece of an actor."""

    mesh: Mesh
    matrix: Floats
    """4x4, from the mesh's frame to the world."""
    actor_id: int
    tag: int
    """Tag of the quads without their own tag."""
    radius_m: float = 4.0
    is_shade: bool = False
    """A shadow, beam or spot of light: translucent, and neither in depths nor in tags."""
    adds: bool = False
    """True for light that is added to what is below."""


@dataclass(frozen=True)
class CapturedScene:
    """All objects of a picture at one time."""

    static_scene: StaticScene
    parts: Sequence[RenderPart]
    light: Light
    frame: int


class Renderer:
    """Draws pictures, one at a time. It caches its buffers and lit colors between frames."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._raster = Raster()
        self._colors: OrderedDict[tuple[int, int, Light], tuple[Mesh, Bytes]] = OrderedDict()

    def rgb(self, shot: CapturedScene, view: CameraView) -> Bytes:
        """Return colors: (height, width, 4) uint8, bytes B G R A."""
        from carlette.camera.rendering.quad_rasterizer import halved  # numba takes half a second to load

        scale = 2 if view.width * view.height <= SUPERSAMPLED_PIXELS else 1
        with self._lock:
            buffer = self._raster.begin(view, scale)
            fill_sky(buffer, view, shot.light)
            self._draw_colors(self._raster, shot, view)
            picture = halved(buffer) if scale == 2 else buffer.copy()
        picture |= np.uint32(0xFF000000)
        return _bytes(picture)

    def depth(self, shot: CapturedScene, view: CameraView) -> Singles:
        """Return distances ahead of the camera's plane in meters, (height, width); 1000 where there is only sky."""
        with self._lock:
            self._raster.begin(view)
            self._draw_flat(self._raster, shot, view, _tag_color)
            return self._raster.depth()

    def tags(self, shot: CapturedScene, view: CameraView) -> Bytes:
        """Return tags in red: (height, width, 4) uint8, bytes B G R A."""
        return self._flat_picture(shot, view, _tag_color)

    def instances(self, shot: CapturedScene, view: CameraView) -> Bytes:
        """Return tags in red, the actor's id in green (low byte) and blue. The ids of the map's objects are 0."""
        return self._flat_picture(shot, view, _instance_color)

    def _flat_picture(self, shot: CapturedScene, view: CameraView, code: _Code) -> Bytes:
        with self._lock:
            buffer = self._raster.begin(view)
            buffer[:] = np.uint32(0xFF000000 | tags.SKY << 16)
            self._draw_flat(self._raster, shot, view, code)
            picture = buffer.copy()
        return _bytes(picture)

    def _draw_colors(self, raster: Raster, shot: CapturedScene, view: CameraView) -> None:
        into, light = view.into_camera(), shot.light
        parts = _seen_parts(shot, view)
        for part in parts:
            if not part.is_shade:
                colors = self._part_colors(part, light)
                colors = _hazed_part(colors, part, view, light)
                raster.draw(part.mesh.corners, colors, into @ part.matrix.astype(np.float32))
        chunks = _seen_chunks(shot.static_scene, view, min(REACH_M, OPAQUE_AIR / light.fog_per_m))
        raster.transform_by(into)
        for chunk, distance in chunks:
            for layer in (PAINT, DETAIL, SOLID):
                if layer in chunk.layers and (layer != DETAIL or distance - chunk.radius_m < DETAIL_M):
                    raster.draw(chunk.layers[layer].corners, _hazed(chunk, layer, distance, view, light))
        raster.draw(dome(light).corners, corner_colors(dome(light), dome(light).colors), _turned_only(into))
        self._draw_translucent(raster, shot, view, (into, chunks, parts))

    def _draw_translucent(
        self,
        raster: Raster,
        shot: CapturedScene,
        view: CameraView,
        visible_parts: tuple[Singles, list[tuple[Chunk, float]], list[RenderPart]],
    ) -> None:
        into, chunks, parts = visible_parts
        light = shot.light
        if light.puddles > 0.02:
            for chunk, distance in chunks:
                if WATER in chunk.layers and distance - chunk.radius_m < DETAIL_M:
                    raster.draw(*_water(chunk.layers[WATER], light), into)
        for part in parts:
            if part.is_shade and not part.adds:
                raster.draw(part.mesh.corners, self._part_colors(part, light), into @ part.matrix.astype(np.float32))
        raster.blend(add=True)
        if light.is_dark:
            for chunk, distance in chunks:
                if NIGHT in chunk.layers and distance - chunk.radius_m < 200.0:
                    raster.draw(chunk.layers[NIGHT].corners, chunk.colors(NIGHT, light), into)
        for part in parts:
            if part.adds:
                raster.draw(part.mesh.corners, self._part_colors(part, light), into @ part.matrix.astype(np.float32))
        if light.rain > 0.1:
            raster.blend()
            raster.use_depth(False)
            raster.draw(*rain_streaks(light.rain, shot.frame), np.eye(4, dtype=np.float32))

    def _draw_flat(self, raster: Raster, shot: CapturedScene, view: CameraView, code: _Code) -> None:
        into = view.into_camera()
        for part in _seen_parts(shot, view):
            if not part.is_shade:
                coded = _corners4(code(part.mesh, part.tag, part.actor_id))
                raster.draw(part.mesh.corners, coded, into @ part.matrix.astype(np.float32))
        for chunk, distance in _seen_chunks(shot.static_scene, view):
            for layer in (PAINT, DETAIL, SOLID):
                if layer in chunk.layers and (layer != DETAIL or distance - chunk.radius_m < DETAIL_M):
                    mesh = chunk.layers[layer]
                    raster.draw(mesh.corners, _expanded_code(mesh), into)

    def _part_colors(self, part: RenderPart, light: Light) -> Bytes:
        """Return the lit colors of a part. They are cached for its heading in steps of six degrees."""
        turn = part.matrix[:3, :3]
        heading = round(math.degrees(math.atan2(turn[1, 0], turn[0, 0])) / 6.0) % 60
        steep = round(float(turn[2, 0]) * 8) * 64 + round(float(turn[2, 1]) * 8) * 1024
        key = (id(part.mesh), heading + steep, light)
        cached = self._colors.get(key)
        if cached is None:
            normals = part.mesh.normals @ turn.T.astype(np.float32)
            lit = light.lit(normals, part.mesh.colors, part.mesh.glow)
            cached = self._colors[key] = (part.mesh, corner_colors(part.mesh, lit, adds=part.adds))
            if len(self._colors) > KEPT_COLORS:
                self._colors.popitem(last=False)
        else:
            self._colors.move_to_end(key)
        return cached[1]


_Code = Callable[[Mesh, int, int], Bytes]


def _tag_color(mesh: Mesh, tag: int, actor_id: int) -> Bytes:
    del actor_id
    return _instance_color(mesh, tag, 0)


def _instance_color(mesh: Mesh, tag: int, actor_id: int) -> Bytes:
    coded = np.zeros((len(mesh), 4), np.uint8)
    coded[:, 0] = actor_id >> 8 & 0xFF
    coded[:, 1] = actor_id & 0xFF
    coded[:, 2] = np.where(mesh.tags == 0, tag, mesh.tags)
    coded[:, 3] = 255
    return coded


def _expanded_code(mesh: Mesh) -> Bytes:
    return _corners4(_instance_color(mesh, 0, 0))


def _bytes(picture: Pixels) -> Bytes:
    """Return pixels as (height, width, 4) bytes B G R A."""
    return picture.view(np.uint8).reshape(*picture.shape, 4)


def _corners4(colors: Bytes) -> Bytes:
    return np.repeat(colors[:, None, :], 4, axis=1)


def _seen_parts(shot: CapturedScene, view: CameraView) -> list[RenderPart]:
    """Return the parts that may be in the picture, the nearest first."""
    if not shot.parts:
        return []
    centers = np.array([part.matrix[:3, 3] for part in shot.parts])
    radii = np.array([part.radius_m for part in shot.parts])
    is_visible = view.sees(centers, radii, PART_M)
    distance = np.linalg.norm(centers - np.array(view.pose.location), axis=1)
    order = np.argsort(np.where(is_visible, distance, np.inf), kind="stable")[: int(is_visible.sum())]
    return [shot.parts[item] for item in order.tolist()]


def _seen_chunks(static_scene: StaticScene, view: CameraView, reach_m: float = REACH_M) -> list[tuple[Chunk, float]]:
    """Return chunks in the picture with their distance, the nearest first."""
    is_visible = view.sees(static_scene.centers, static_scene.radii, reach_m)
    distance = np.linalg.norm(static_scene.centers - np.array(view.pose.location), axis=1)
    order = np.argsort(np.where(is_visible, distance, np.inf), kind="stable")[: int(is_visible.sum())]
    return [(static_scene.chunks[item], float(distance[item])) for item in order.tolist()]


def _hazed(chunk: Chunk, layer: str, distance: float, view: CameraView, light: Light) -> Bytes:
    """Return the colors of a chunk through the air."""
    colors = chunk.colors(layer, light)
    if light.fog_per_m <= CLEAR_PER_M:
        share = round((1.0 - math.exp(-max(distance - 40.0, 0.0) * light.fog_per_m)) * 32) / 32
        return colors if share <= 0 else chunk.faded(layer, light, share)
    gap = chunk.layers[layer].corners - np.array(view.pose.location, np.float32)
    return _veiled(colors, gap, light)


def _veiled(colors: Bytes, gap: Singles, light: Light) -> Bytes:
    """Return colors (n, 4, 4) of corners at the offsets `gap` (n, 4, 3) from the camera, through fog."""
    away: Singles = np.sqrt(np.einsum("nij,nij->ni", gap, gap))
    share = (255.0 - 255.0 * np.exp(-away * np.float32(light.fog_per_m))).astype(np.uint16)[..., None]
    fog = np.array([light.fog[2], light.fog[1], light.fog[0], 255], np.uint16)
    veiled: Bytes = ((colors * (np.uint16(255) - share) + fog * share) >> 8).astype(np.uint8)
    veiled[..., 3] = colors[..., 3]
    return veiled


def _hazed_part(colors: Bytes, part: RenderPart, view: CameraView, light: Light) -> Bytes:
    if light.fog_per_m <= CLEAR_PER_M:
        return colors
    away = float(np.linalg.norm(part.matrix[:3, 3] - np.array(view.pose.location)))
    share = 1.0 - math.exp(-away * light.fog_per_m)
    fog = np.array([light.fog[2], light.fog[1], light.fog[0], 255], np.float32)
    veiled: Bytes = (colors + (fog - colors) * np.float32(share)).astype(np.uint8)
    veiled[part.mesh.glow] = (colors + (fog - colors) * np.float32(0.6 * share))[part.mesh.glow].astype(np.uint8)
    return veiled


def _water(mesh: Mesh, light: Light) -> tuple[Singles, Bytes]:
    """Return the puddles at this wetness, in the color of the sky that they mirror."""
    there = mesh.colors[:, 3] <= light.puddles * 100
    red, green, blue = (int(0.55 * a + 0.35 * b) for a, b in zip(light.horizon, light.zenith, strict=True))
    colors = np.empty((int(there.sum()), 4, 4), np.uint8)
    colors[:] = (blue, green, red, 170)
    return np.ascontiguousarray(mesh.corners[there]), colors


def _turned_only(into: Singles) -> Singles:
    turned: Singles = into.copy()
    turned[:3, 3] = 0.0
    return turned


__all__ = ["LAYERS", "CapturedScene", "RenderPart", "Renderer"]
