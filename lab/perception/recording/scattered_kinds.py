"""The kinds of objects of a crowd: the frequency, the required space and the blueprints of each."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import Any

import carla

from stucksolver.scene import ObjectKind
from stucksolver_carla.stack.object_kinds import kind_of

Shares = Sequence[tuple[ObjectKind, float]]
LOW_SHARES = ((ObjectKind.BAG, 1.0), (ObjectKind.LITTER, 1.0), (ObjectKind.DEBRIS, 2.0))
"""Relative frequencies of low objects on the road. Ours."""
LOW = tuple(kind for kind, _ in LOW_SHARES)
SHARES = (
    (ObjectKind.CAR, 5.0),
    (ObjectKind.EMERGENCY, 2.0),
    (ObjectKind.VAN, 2.0),
    (ObjectKind.TRUCK, 2.0),
    (ObjectKind.BUS, 2.0),
    (ObjectKind.SCHOOL_BUS, 2.0),
    (ObjectKind.MOTORCYCLE, 2.0),
    (ObjectKind.BICYCLE, 3.0),
    (ObjectKind.PEDESTRIAN, 5.0),
    (ObjectKind.FLAGGER, 1.0),
    (ObjectKind.ANIMAL, 3.0),
    (ObjectKind.CONE, 3.0),
    (ObjectKind.BARRIER, 3.0),
    (ObjectKind.CROSSING_GATE, 0.3),
    (ObjectKind.PROP, 2.0),
)
"""Relative frequency of each kind beside the road. Ours; within a kind, all blueprints are equally likely."""
ON_WHEELS = (
    ObjectKind.CAR,
    ObjectKind.EMERGENCY,
    ObjectKind.VAN,
    ObjectKind.TRUCK,
    ObjectKind.BUS,
    ObjectKind.SCHOOL_BUS,
    ObjectKind.MOTORCYCLE,
    ObjectKind.BICYCLE,
)
ON_FEET = (ObjectKind.PEDESTRIAN, ObjectKind.FLAGGER, ObjectKind.ANIMAL)
REACH_OF_M = {
    ObjectKind.MOTORCYCLE: 1.1,
    ObjectKind.BICYCLE: 1.0,
    ObjectKind.CAR: 2.2,
    ObjectKind.EMERGENCY: 2.8,
    ObjectKind.VAN: 2.8,
    ObjectKind.TRUCK: 3.5,
    ObjectKind.BUS: 4.0,
    ObjectKind.SCHOOL_BUS: 4.5,
}
"""Radius of the space that an object requires (m). Ours.

It is smaller than half its length, because vehicles stand in rows.
"""
_FLAGGER = "walker.flagger"


def deal(shares: Shares, count: int, chance: Random) -> list[ObjectKind]:
    """Return about `count` kinds in these shares, largest first: large objects require space that is still free."""
    total = sum(share for _, share in shares)
    deck: list[ObjectKind] = []
    for kind, share in shares:
        wanted = count * share / total
        deck += [kind] * (int(wanted) + (chance.random() < wanted % 1.0))
    chance.shuffle(deck)
    return sorted(deck, key=lambda kind: -REACH_OF_M.get(kind, 0.0))


def blueprints_by_kind(library: Any) -> dict[ObjectKind, list[str]]:
    """Return the names of all blueprints with a body, by kind."""
    found: dict[ObjectKind, list[str]] = {}
    for blueprint in sorted(library, key=lambda item: str(item.id)):
        name = str(blueprint.id)
        if not name.startswith(("vehicle.", "walker.", "animal.", "static.prop.")) or name == "static.prop.mesh":
            continue
        kind = ObjectKind.FLAGGER if name.startswith(_FLAGGER) else kind_of(name, _public(blueprint))
        found.setdefault(kind, []).append(name)
    return found


def _public(blueprint: carla.ActorBlueprint) -> dict[str, str]:
    """Return the attributes of a blueprint that determine its kind."""
    names = ("special_type", "base_type", "number_of_wheels")
    return {name: _text(blueprint.get_attribute(name)) for name in names if blueprint.has_attribute(name)}


def _text(attribute: carla.ActorAttribute) -> str:
    whole = attribute.type == carla.ActorAttributeType.Int
    return str(attribute.as_int()) if whole else str(attribute.as_str())
