"""Behaviors of a scene with their parameters on a grid that follows from the registry: a new one needs no change.

The values of distances, offsets and speeds come from the scene: how far it is past the objects ahead, and what the law
and the vehicle allow.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from typing import Any

from pydantic import ValidationError

from stucksolver.plan.behaviors import REGISTRY, Behavior, ExecutorKind, parse_behavior
from stucksolver.scene import GuidanceIntent, Scene, SceneObject
from stucksolver.scene.own_path import is_beside_path, is_in_own_path, own_path_ahead

SPEEDS_MPS = (5.5, 2.2)
"""Speeds to try (m/s): just under the 20 km/h of a recovery, and walking pace."""
OFFSETS_M = (0.4, 1.0)
"""Lateral shifts to try (m). Ours."""
ON_M = (25.0, 15.0)
"""Distances to drive on (m): more than the progress of a recovery, and just that. Ours."""
BEYOND_M = 3.0
"""Distance of the ego's rear beyond an object that it has passed (m). Ours."""
WITHIN_M = 45.0
"""Objects further ahead are not passed by the first plan (m). Ours."""
ASIDE_M = 2.0
"""Objects beside the route up to this lateral distance from the ego's path matter (m). Ours."""
ABOVE = 0.05
"""Distance from an exclusive bound, in the unit of the parameter. Ours."""
MOST_OBJECTS = 4
"""Number of objects ahead to try for a parameter that names one. Ours."""
MOST_PASSED = 2
"""Number of objects in the path that a distance may lead past. Ours."""


def past_m(scene: Scene, obj: SceneObject) -> float:
    """Return the distance that the ego drives until its rear is beyond an object (m)."""
    return math.ceil(2.0 * ((obj.gap_m or 0.0) + obj.length_m + scene.ego.length_m + BEYOND_M)) / 2.0


def objects_ahead(scene: Scene) -> tuple[SceneObject, ...]:
    """Return the objects in or near the ego's path ahead: those in it first, then the nearest."""
    near = [o for o in scene.objects if -scene.ego.length_m < (o.gap_m or 0.0) and is_beside_path(scene, o, ASIDE_M)]
    within = [o for o in near if o.gap_m is not None and o.gap_m < WITHIN_M]
    return tuple(sorted(within, key=lambda o: (not is_in_own_path(scene, o), o.gap_m or 0.0)))[:MOST_OBJECTS]


def leads_on(kind: type[Behavior]) -> bool:
    """True for behaviors that can end a plan: they move the ego along a path, and not only on request."""
    only_on_request = bool(kind.intents) and kind.solution_rank is None
    moves = kind.executor is ExecutorKind.PATH and not kind.calls_person and not kind.reverse
    return moves and not only_on_request and not (kind.prepares and not kind.intents)


def behaviors_on_grid(scene: Scene) -> tuple[Behavior, ...]:
    """Return every offered behavior that can end a plan, at every point of its grid."""
    found: list[Behavior] = []
    for item in scene.behaviors:
        kind = REGISTRY.get(item.name)
        if kind is not None and leads_on(kind) and kind.fits_scene(scene):
            found += on_grid(scene, kind)
    return tuple(dict.fromkeys(found))


def on_grid(scene: Scene, kind: type[Behavior], **fixed: Iterable[Any]) -> list[Behavior]:
    """Return a behavior at every point of its grid. `fixed`: values of some parameters instead of the grid's."""
    schema: dict[str, Any] = kind.model_json_schema()["properties"]
    axes = {name: _clipped(fixed.get(name) or _values(name, item, scene), item) for name, item in schema.items()}
    points = (dict(zip(axes, point, strict=True)) for point in itertools.product(*axes.values()))
    parsed = (_parsed(point) for point in points)
    return list(dict.fromkeys(behavior for behavior in parsed if behavior is not None))


def _parsed(data: dict[str, Any]) -> Behavior | None:
    try:
        return parse_behavior(data)
    except ValidationError:
        # Values that are valid alone need not be valid together.
        return None


def _values(name: str, schema: dict[str, Any], scene: Scene) -> tuple[Any, ...]:
    """Return the values to try for one parameter."""
    if "const" in schema:
        return (schema["const"],)
    if "enum" in schema:
        return tuple(schema["enum"])
    if schema.get("type") == "number":
        return _numbers(name, schema, scene)
    if schema.get("type") == "boolean":
        return (schema.get("default", False),)
    ids = tuple(o.id for o in objects_ahead(scene))
    optional = any(kind.get("type") == "null" for kind in schema.get("anyOf", ()))
    return (*ids, None) if optional else ids


def _numbers(name: str, schema: dict[str, Any], scene: Scene) -> tuple[float, ...]:
    if name == "speed_mps":
        return _speeds_mps(scene)
    if name == "offset_m":
        return OFFSETS_M
    if name == "distance_m":
        return (*(past_m(scene, o) for o in _passable(scene)), *ON_M)
    return (float(schema["default"]),) if "default" in schema else ()


def _passable(scene: Scene) -> tuple[SceneObject, ...]:
    """Return the nearest objects in the ego's path that a distance may lead past."""
    return tuple(o for o in own_path_ahead(scene) if (o.gap_m or 0.0) < WITHIN_M)[:MOST_PASSED]


def _speeds_mps(scene: Scene) -> tuple[float, ...]:
    """Return the speeds to try (m/s). A passenger who asks to overtake asks for more than the speed of a recovery."""
    reading = None if scene.guidance is None else scene.guidance.reading
    overtakes = reading is not None and reading.intent is GuidanceIntent.OVERTAKE
    if not overtakes or scene.speed_limit_mps is None:
        return SPEEDS_MPS
    # Rounded down: the guard allows not a hair more than the limit.
    limit_mps = math.floor(10.0 * scene.speed_limit_mps) / 10.0
    return (*SPEEDS_MPS, limit_mps) if limit_mps > SPEEDS_MPS[0] else SPEEDS_MPS


def _clipped(values: Iterable[Any], schema: dict[str, Any]) -> tuple[Any, ...]:
    """Return the values within the bounds of a number; values that would be clipped to the same number count once."""
    if schema.get("type") != "number":
        return tuple(values)
    return tuple(dict.fromkeys(clipped(float(value), schema) for value in values))


def clipped(value: float, schema: dict[str, Any]) -> float:
    """Return a number within the bounds of its schema, rounded to hundredths."""
    low: float = schema.get("minimum", schema.get("exclusiveMinimum", -math.inf) + ABOVE)
    high: float = schema.get("maximum", math.inf)
    return round(min(max(value, low), high), 2)
