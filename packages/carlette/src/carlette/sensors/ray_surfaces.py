"""Surfaces that rays can hit, as flat quads: the static scene of a map and the bodies of actors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from threading import Lock
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from carlette.camera.environment.static_scene import SOLID
from carlette.camera.models.mesh import Mesh, normals_of
from carlette.camera.rendering.scene_capture import static_scene_of
from carlette.geometry import Floats
from carlette.opendrive.road_network import RoadNetwork

Singles = NDArray[np.float32]
Indices = NDArray[np.int64]

FLAT_M = 0.002
"""Distance of a quad's last corner from the plane of the others above which it is split into triangles (m). Ours."""


@dataclass(frozen=True)
class RaySurfaces:
    """Quads of several bodies, grouped by body, each in its body's frame."""

    corners: Singles
    """(n, 4, 3) (m); (b - a) x (d - a) points outwards."""
    normals: Singles
    """(n, 3), unit length."""
    tags: NDArray[np.uint8]
    """(n,): `CityObjectLabel`."""
    spans: Indices
    """(b, 2): first quad of each body, and one more than its last."""
    centers: Floats
    """(b, 3): center of each body's bounding sphere."""
    radii: Floats

    @property
    def body_of(self) -> Indices:
        """The body of each quad, (n,)."""
        return np.repeat(np.arange(len(self.spans)), self.spans[:, 1] - self.spans[:, 0])


def faces_of(meshes: Sequence[Mesh]) -> RaySurfaces:
    """Return one body for each mesh."""
    flat = [_flattened(mesh.corners, mesh.tags) for mesh in meshes]
    counts = [len(corners) for corners, _ in flat]
    ends = np.cumsum([0, *counts])
    corners = np.concatenate([item for item, _ in flat] or [np.zeros((0, 4, 3), np.float32)])
    lows = [item.min(axis=(0, 1)) if len(item) else np.zeros(3) for item, _ in flat]
    highs = [item.max(axis=(0, 1)) if len(item) else np.zeros(3) for item, _ in flat]
    low, high = np.array(lows, float).reshape(-1, 3), np.array(highs, float).reshape(-1, 3)
    return RaySurfaces(
        np.ascontiguousarray(corners, np.float32),
        normals_of(corners),
        np.concatenate([tags for _, tags in flat] or [np.zeros(0, np.uint8)]),
        np.stack([ends[:-1], ends[1:]], axis=1),
        (low + high) / 2.0,
        np.linalg.norm(high - low, axis=1) / 2.0,
    )


_building = Lock()
_static: WeakKeyDictionary[RoadNetwork, RaySurfaces] = WeakKeyDictionary()


def static_faces(network: RoadNetwork) -> RaySurfaces:
    """Return the surfaces of a map that the cameras draw, without paint."""
    with _building:
        found = _static.get(network)
        if found is None:
            meshes = [chunk.layers[SOLID] for chunk in static_scene_of(network).chunks if SOLID in chunk.layers]
            found = _static[network] = faces_of(meshes)
        return found


def _flattened(corners: Singles, tags: NDArray[np.uint8]) -> tuple[Singles, NDArray[np.uint8]]:
    """Return the same surface without twisted quads."""
    a, b, c, d = (corners[:, i].astype(float) for i in range(4))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    out = np.abs((normal * (d - a)).sum(axis=1)) > FLAT_M * np.maximum(length, 1e-9)
    twisted = corners[out]
    first, second = twisted[:, [0, 1, 2, 2]], twisted[:, [0, 2, 3, 3]]
    return np.concatenate([corners[~out], first, second]), np.concatenate([tags[~out], tags[out], tags[out]])
