"""Selects the offered behaviors that make sense in a scene. The others would only lengthen the prompt."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from stucksolver.plan.behaviors import REGISTRY
from stucksolver.scene import (
    MOTOR_VEHICLES,
    PASSABLE_KINDS,
    AvailableBehavior,
    LaneDirection,
    LaneKind,
    LaneRelation,
    Scene,
)

OFF_LANE_M = 0.5
"""Lateral offset from which `rejoin_route` is offered (m). Ours."""


def known_behaviors(scene: Scene) -> tuple[AvailableBehavior, ...]:
    """Return all known behaviors that the stack offers. They are the same in every scene of a run."""
    return tuple(b for b in scene.behaviors if b.name in REGISTRY)


def available(scene: Scene) -> tuple[AvailableBehavior, ...]:
    """Return the behaviors that have an object or a lane to act on here. The guard still checks each plan."""
    return tuple(b for b in known_behaviors(scene) if b.name not in NEEDS or NEEDS[b.name](scene))


def signature(behavior: AvailableBehavior) -> str:
    """Return a behavior with its parameters and their ranges: `change_lane(side left|right, distance_m 15..150)`."""
    fields = cast("dict[str, dict[str, Any]]", behavior.parameters["properties"])
    return f"{behavior.name}({', '.join(_parameter(k, v) for k, v in fields.items() if k != 'name')})"


def _parameter(name: str, schema: dict[str, Any]) -> str:
    parts = [schema, *schema.get("anyOf", [])]
    if name.endswith("_id") or name == "route_start":
        return name
    choices = next((p["enum"] for p in parts if "enum" in p), None)
    if choices is not None:
        return f"{name} {'|'.join(map(str, choices))}"
    low, high = _bound(parts, "minimum"), _bound(parts, "maximum")
    or_null = " or null" if any(p.get("type") == "null" for p in parts) else ""
    return name + ("" if low is None and high is None else f" {low or ''}..{high or ''}{or_null}")


def _bound(parts: list[dict[str, Any]], which: str) -> str | None:
    """Return the bound, with `>` or `<` if the range excludes it."""
    for part in parts:
        if which in part:
            return f"{part[which]:g}"
        exclusive = f"exclusive{which.capitalize()}"
        if exclusive in part:
            return (">" if which == "minimum" else "<") + f"{part[exclusive]:g}"
    return None


def _has_adjacent_lane(scene: Scene) -> bool:
    adjacent = (LaneRelation.LEFT, LaneRelation.RIGHT)
    return any(x.relation in adjacent and x.direction is LaneDirection.SAME for x in scene.lanes)


def _has_oncoming_lane(scene: Scene) -> bool:
    lanes = any(x.direction is LaneDirection.OPPOSITE and x.kind is LaneKind.DRIVING for x in scene.lanes)
    return lanes and bool(scene.objects)


def _has_lead(scene: Scene) -> bool:
    return any(o.in_path and o.kind in MOTOR_VEHICLES and o.speed_along_mps > 0.5 for o in scene.objects)


def _has_passable_object(scene: Scene) -> bool:
    return any(o.kind in PASSABLE_KINDS for o in scene.objects)


def _is_off_lane(scene: Scene) -> bool:
    return abs(scene.ego.lateral_offset_m) > OFF_LANE_M


def _has_route_start(scene: Scene) -> bool:
    return bool(scene.waypoints)


NEEDS: dict[str, Callable[[Scene], bool]] = {
    "change_lane": _has_adjacent_lane,
    "borrow_oncoming_lane": _has_oncoming_lane,
    "follow_vehicle": _has_lead,
    "drive_over": _has_passable_object,
    "rejoin_route": _is_off_lane,
    "replan": _has_route_start,
}
