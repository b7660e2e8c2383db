"""The candidate plans of a scene: all its behaviors, with parameters on a grid.

The grid follows from the schemas in the scene, which come from the registry. A new behavior needs no change here.
"""

from __future__ import annotations

import itertools
from functools import cache
from typing import Any

from pydantic import ValidationError

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import REGISTRY, Behavior, parse_behavior
from stucksolver.scene import Scene
from stucksolver_language.llm.offered_behaviors import available

STEPS, PAIR_STEPS = 2, 1
"""Values of each number in plans of one and of two behaviors.

The guard's bounds are coarser than a finer grid. Ours.
"""
GETS_ON_M = 5.0
"""Shortest distance that a plan must lead (m): the detector's own measure of progress.

A shorter plan would end in the situation in which it began. Without this limit the student moved by plans of half
a meter.
"""
MOST_IDS = 3
"""Number of objects or waypoints to try for each parameter that names one. Ours."""
AWAY_M, AWAY_MPS = (15.0, 20.0), (1.08, 1.8)
"""Distances (m) and speeds (m/s) of a short lane change before the return.

A search over a wider grid found that the guard accepts only short and slow ones if an object also blocks the other
lane. At 0.8 m/s a plan was aborted between the lanes, since too little of the rear was visible.
"""
BACK_M, BACK_MPS, REJOIN_MPS = 15.0, (1.5, 3.93), 4.0
"""Distance (m) and speeds (m/s) of the lane change back, and the speed of `rejoin_route` as its alternative (m/s).

Ours.
"""
Values = tuple[Any, ...]


def candidates(scene: Scene) -> tuple[RecoveryPlan, ...]:
    """Return the plans among which the student chooses.

    They are each behavior that moves the vehicle on, alone and after each behavior that prepares another one, and short
    lane changes with a return. Waiting is not among them, since it is a separate choice.

    Args:
        scene: The scene, with the behaviors that the stack offers.
    """
    fitting = {item.name for item in available(scene)}
    moving = [item for item in offered(scene, STEPS) if item.name in fitting and not item.stands_still]
    single = [(obj,) for obj in moving if _gets_on(obj)]
    short = [item for item in offered(scene, PAIR_STEPS) if item.name in fitting and not item.stands_still]
    pairs = [(item, two) for item in short if item.prepares for two in short if _gets_on(two)]
    # The return need not fit before the ego has left its lane.
    returning = [(out, back) for out, back in there_and_back() if out.name in fitting and scene.offers(back.name)]
    return tuple(RecoveryPlan.model_validate({"behaviors": plan}) for plan in (*single, *pairs, *returning))


@cache
def there_and_back() -> tuple[tuple[Behavior, Behavior], ...]:
    """Return short lane changes, each with a return.

    They pass an object where the other lane is free for little more than the ego's length.
    """
    found: list[tuple[Behavior, Behavior]] = []
    for side, other in (("left", "right"), ("right", "left")):
        ways_back = [_lane_change(other, BACK_M, speed) for speed in BACK_MPS]
        ways_back.append(parse_behavior({"name": "rejoin_route", "speed_mps": REJOIN_MPS}))
        for distance, speed in itertools.product(AWAY_M, AWAY_MPS):
            found += [(_lane_change(side, distance, speed), back) for back in ways_back]
    return tuple(found)


def _lane_change(side: str, distance_m: float, speed_mps: float) -> Behavior:
    return parse_behavior({"name": "change_lane", "side": side, "distance_m": distance_m, "speed_mps": speed_mps})


def leads_on(plan: RecoveryPlan) -> bool:
    """True if a plan can get the vehicle on. After a plan that only backs up, for example, another one is needed."""
    return any(_gets_on(behavior) for behavior in plan.behaviors)


def _gets_on(behavior: Behavior) -> bool:
    return not (behavior.stands_still or behavior.prepares) and getattr(behavior, "distance_m", GETS_ON_M) >= GETS_ON_M


def offered(scene: Scene, steps: int) -> tuple[Behavior, ...]:
    """Return every offered behavior at every point of the grid.

    Args:
        scene: The scene, with the behaviors that the stack offers.
        steps: Number of values of each number, spread evenly on a logarithmic scale between its bounds.
    """
    found: list[Behavior] = []
    for item in scene.behaviors:
        kind = REGISTRY.get(item.name)
        # A plan that calls a person is no candidate: the search that labels the plans has no person to call.
        if kind is None or kind.calls_person:
            continue
        properties: Any = item.parameters["properties"]
        axes = {name: _values(name, schema, scene, steps) for name, schema in properties.items()}
        for point in itertools.product(*axes.values()):
            behavior = _parsed(dict(zip(axes, point, strict=True)))
            if behavior is not None:
                found.append(behavior)
    return tuple(dict.fromkeys(found))


def _parsed(data: dict[str, Any]) -> Behavior | None:
    """Return the behavior, or None if the parameters are valid individually but not together."""
    try:
        return parse_behavior(data)
    except ValidationError:
        # The grid combines values freely, and the schema of a parameter says nothing about the others.
        return None


def _values(name: str, schema: dict[str, Any], scene: Scene, steps: int) -> Values:
    if "const" in schema:
        return (schema["const"],)
    if "enum" in schema:
        return tuple(schema["enum"])
    if schema.get("type") == "number":
        return _numbers(schema, steps)
    if schema.get("type") == "boolean":
        return (True, False)
    ids = _waypoints(scene) if name == "route_start" else _objects(scene)
    optional = any(kind.get("type") == "null" for kind in schema.get("anyOf", ()))
    return (*ids, None) if optional else ids


def _numbers(schema: dict[str, Any], steps: int) -> Values:
    """Return the values of a number: its default, and a grid with its bounds unless the schema excludes them."""
    open_low = "minimum" not in schema
    low, high = float(schema["exclusiveMinimum" if open_low else "minimum"]), float(schema["maximum"])
    parts = [(k + open_low) / (steps - 1 + open_low) for k in range(steps)] if steps > 1 else [0.5]
    spread = [low * (high / low) ** part for part in parts]
    default = [float(schema["default"])] if "default" in schema else []
    return tuple(dict.fromkeys(round(value, 2) for value in (*default, *spread)))


def _objects(scene: Scene) -> Values:
    """Return ids of objects: those in the path ahead first, then the nearest others ahead."""
    others = sorted((o for o in scene.objects if o.gap_m is not None and o.gap_m > 0.0), key=lambda o: o.gap_m or 0.0)
    ids = dict.fromkeys(o.id for o in (*scene.in_path_ahead(), *others))
    return tuple(ids)[:MOST_IDS]


def _waypoints(scene: Scene) -> Values:
    """Return ids of the nearest waypoints from which the destination is reachable."""
    fitting = sorted((w for w in scene.waypoints if w.reaches_destination is not False), key=lambda w: w.distance_m)
    return tuple(w.id for w in fitting)[:MOST_IDS]
