"""Words for objects: `a truck`, `two cyclists`."""

from __future__ import annotations

from collections.abc import Sequence

from stucksolver.scene import ObjectKind, Scene

THINGS: dict[ObjectKind, tuple[str, str]] = {
    ObjectKind.CAR: ("a car", "cars"),
    ObjectKind.VAN: ("a van", "vans"),
    ObjectKind.TRUCK: ("a truck", "trucks"),
    ObjectKind.BUS: ("a bus", "buses"),
    ObjectKind.SCHOOL_BUS: ("a school bus", "school buses"),
    ObjectKind.EMERGENCY: ("an emergency vehicle", "emergency vehicles"),
    ObjectKind.MOTORCYCLE: ("a motorcycle", "motorcycles"),
    ObjectKind.BICYCLE: ("a cyclist", "cyclists"),
    ObjectKind.PEDESTRIAN: ("a pedestrian", "pedestrians"),
    ObjectKind.FLAGGER: ("someone directing the traffic", "people directing the traffic"),
    ObjectKind.ANIMAL: ("an animal", "animals"),
    ObjectKind.CONE: ("a traffic cone", "traffic cones"),
    ObjectKind.BARRIER: ("a barrier", "barriers"),
    ObjectKind.CROSSING_GATE: ("a crossing gate", "crossing gates"),
    ObjectKind.BAG: ("a bag", "bags"),
    ObjectKind.LITTER: ("some litter", "litter"),
    ObjectKind.DEBRIS: ("debris", "debris"),
    ObjectKind.PROP: ("an object", "objects"),
    ObjectKind.UNKNOWN: ("something that I cannot make out", "things that I cannot make out"),
}
"""Singular and plural."""
SOMEBODY = "somebody"
SOMETHING = "something"
NUMBERS = ("no", "one", "two", "three", "four", "five")
COUNTED = frozenset(THINGS) - {ObjectKind.LITTER, ObjectKind.DEBRIS}
"""Kinds with a plural."""


def noun(kind: ObjectKind) -> str:
    """Return one object of a kind, with its article."""
    return THINGS[kind][0]


def nouns(kinds: Sequence[ObjectKind]) -> str:
    """Return several objects: `two cyclists` if they are alike, else the first of them; `something` for none."""
    if not kinds:
        return SOMETHING
    first = kinds[0]
    alike = len(kinds) > 1 and set(kinds) == {first} and first in COUNTED
    if not alike:
        return noun(first)
    count = NUMBERS[len(kinds)] if len(kinds) < len(NUMBERS) else str(len(kinds))
    return f"{count} {THINGS[first][1]}"


def noun_of(object_id: str | None, scene: Scene | None, otherwise: str = SOMEBODY) -> str:
    """Return the word for an object of a scene; `otherwise` if the scene does not contain it."""
    found = () if scene is None or object_id is None else scene.objects
    return next((noun(item.kind) for item in found if item.id == object_id), otherwise)


def capitalize(text: str) -> str:
    """Return the text with a capital first letter."""
    return text[:1].upper() + text[1:]
