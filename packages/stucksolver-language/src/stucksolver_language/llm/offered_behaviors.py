"""Selects the offered behaviors that make sense in a scene. The others would only lengthen the prompt."""

from __future__ import annotations

from typing import Any, cast

from stucksolver.plan.behaviors import REGISTRY
from stucksolver.scene import AvailableBehavior, Scene


def known_behaviors(scene: Scene) -> tuple[AvailableBehavior, ...]:
    """Return all known behaviors that the stack offers. They are the same in every scene of a run."""
    return tuple(b for b in scene.behaviors if b.name in REGISTRY)


def available(scene: Scene) -> tuple[AvailableBehavior, ...]:
    """Return the behaviors that have something to act on here. The guard still judges each plan."""
    return tuple(b for b in known_behaviors(scene) if REGISTRY[b.name].fits_scene(scene))


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
