"""What is in the path of an ego that drives on at its present lateral offset, in the route's lane or beside it."""

from __future__ import annotations

from stucksolver.scene.scene import TOUCHING_M, Scene, SceneObject
from stucksolver.scene.scene_builder import PATH_MARGIN_M

IN_LANE_M = 1.0
"""Lateral offset up to which the ego counts as in the route's lane (m)."""


def is_in_own_path(scene: Scene, obj: SceneObject) -> bool:
    """True if the ego would hit an object when it drives on at its present lateral offset."""
    return obj.in_path if abs(scene.ego.lateral_offset_m) < IN_LANE_M else is_beside_path(scene, obj, PATH_MARGIN_M)


def own_path_ahead(scene: Scene) -> tuple[SceneObject, ...]:
    """Return the objects ahead that the ego would hit at its present lateral offset, nearest first."""
    found = [o for o in scene.objects if o.gap_m is not None and o.gap_m > TOUCHING_M and is_in_own_path(scene, o)]
    return tuple(sorted(found, key=lambda o: o.gap_m or 0.0))


def nearest_ahead(scene: Scene, within_m: float) -> SceneObject | None:
    """Return the nearest object in the ego's own path with a gap below `within_m` (m), or None."""
    return next((o for o in own_path_ahead(scene) if (o.gap_m or 0.0) < within_m), None)


def is_beside_path(scene: Scene, obj: SceneObject, within_m: float) -> bool:
    """True if an object is less than `within_m` (m) beside the body of an ego that drives on at its lateral offset."""
    half, here = scene.ego.width_m / 2 + within_m, scene.ego.lateral_offset_m
    return obj.right_edge_m - here < half and obj.left_edge_m - here > -half
