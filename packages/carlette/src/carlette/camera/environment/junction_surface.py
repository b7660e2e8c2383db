"""Asphalt in the gaps between the roads of a junction. Maps define each turn as a separate road, with gaps between."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import shapely

from carlette.camera.environment.road_surface import JUNCTION, Pavement, upward
from carlette.camera.models.mesh import Color, Mesh, quads
from carlette.camera.rendering import tags
from carlette.geometry import Floats

LARGEST_GAP_M2 = 450.0
"""Largest hole between lanes that counts as a gap (m²). Ours."""
BELOW_M = 0.03
"""Height below the lanes, which overlap its edges (m). Ours."""
CLOSE_M = 0.15
"""Distance below which two lanes leave no gap (m). Ours."""


def fill_gaps(pavement: Pavement, color: Color = JUNCTION) -> list[Mesh]:
    """Return meshes of all gaps in all junctions."""
    if not pavement.junctions:
        return []
    lanes = shapely.polygons(np.concatenate(pavement.lanes))
    tree = shapely.STRtree(lanes)
    made = []
    for strips in pavement.junctions.values():
        corners = np.concatenate(strips)
        around = shapely.MultiPoint(corners[..., :2].reshape(-1, 2)).envelope.buffer(2.0)
        near = lanes[tree.query(around, predicate="intersects")]
        triangles = [triangle for gap in _gaps(near) for triangle in _triangles(gap, corners.reshape(-1, 3))]
        if triangles:
            made.append(quads(upward(np.array(triangles)), color, tags.ROAD))
    return made


def _gaps(lanes: Any) -> Iterator[Any]:
    """Yield closed holes between lanes."""
    joined = shapely.union_all(shapely.buffer(shapely.make_valid(lanes), CLOSE_M, quad_segs=1))
    for part in shapely.get_parts(joined):
        for ring in shapely.get_rings(part)[1:]:
            hole = shapely.buffer(shapely.Polygon(ring), 2 * CLOSE_M)
            if hole.area < LARGEST_GAP_M2:
                yield hole


def _triangles(gap: Any, known: Floats) -> Iterator[Floats]:
    """Yield triangles (4, 3; the last corner twice) that cover a gap, at the height of the nearest lane."""
    for triangle in shapely.get_parts(shapely.delaunay_triangles(gap)):
        if gap.contains(triangle.centroid):
            flat = np.array(triangle.exterior.coords)[:3]
            nearest = ((known[None, :, :2] - flat[:, None, :]) ** 2).sum(axis=2).argmin(axis=1)
            corners = np.column_stack([flat, known[nearest, 2] - BELOW_M])
            yield corners[[0, 1, 2, 2]]
