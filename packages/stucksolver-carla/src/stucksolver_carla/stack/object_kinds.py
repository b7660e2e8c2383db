"""Maps a CARLA blueprint to a kind of object, from visible properties only: never from role names."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from stucksolver.scene import ObjectKind

if TYPE_CHECKING:
    import carla

_BASE_TYPES = {
    "car": ObjectKind.CAR,
    "van": ObjectKind.VAN,
    "truck": ObjectKind.TRUCK,
    "bus": ObjectKind.BUS,
    "motorcycle": ObjectKind.MOTORCYCLE,
    "bicycle": ObjectKind.BICYCLE,
}
_TWO_WHEELERS = ("crossbike", "century", "omafiets")
_PROPS = (
    (r".*cone.*", ObjectKind.CONE),
    (r"crossinggate.*", ObjectKind.CROSSING_GATE),
    (r".*(barrier|warning).*", ObjectKind.BARRIER),
    (r"(plastic|paper)bag.*", ObjectKind.BAG),
    (r"(garbage|paper|creasedbox|colacan).*", ObjectKind.LITTER),
    (r".*(debris|bag|brokentile|rock|tyre|plank).*", ObjectKind.DEBRIS),
)


def kind_of(type_id: str, attributes: dict[str, str]) -> ObjectKind:
    """Return the kind for a blueprint's id and its public attributes (`base_type` and `special_type` since 0.9.13)."""
    if type_id.startswith("animal."):
        return ObjectKind.ANIMAL
    if type_id.startswith("walker."):
        return ObjectKind.PEDESTRIAN
    if type_id.startswith("vehicle."):
        return _vehicle(type_id, attributes)
    name = type_id.rsplit(".", 1)[-1]
    return next((kind for pattern, kind in _PROPS if re.fullmatch(pattern, name)), ObjectKind.PROP)


def _vehicle(type_id: str, attributes: dict[str, str]) -> ObjectKind:
    if "school" in type_id:
        return ObjectKind.SCHOOL_BUS
    if attributes.get("special_type") == "emergency":
        return ObjectKind.EMERGENCY
    base = _BASE_TYPES.get(attributes.get("base_type", "").lower())
    if base is not None:
        return base
    if any(name in type_id for name in _TWO_WHEELERS):
        return ObjectKind.BICYCLE
    return ObjectKind.MOTORCYCLE if attributes.get("number_of_wheels") == "2" else ObjectKind.CAR


def attributes_of(actor: carla.Actor) -> dict[str, str]:
    """Return the attributes of an actor that determine its kind."""
    names = ("special_type", "base_type", "number_of_wheels")
    return {name: str(actor.attributes[name]) for name in names if name in actor.attributes}
