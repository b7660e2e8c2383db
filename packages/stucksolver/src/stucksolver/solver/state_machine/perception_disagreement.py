"""Handles a reasoner that looks at the image and contradicts perception.

A doubt only takes away. Perception allows something when it calls an object soft or immovable, or a light green or off.
If the reasoner contradicts it, the object or light counts as unknown for a while. Nothing that a model says changes
what forbids (a person, a vehicle, a school bus, a red light), and nothing that a model says makes an object harmless.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple, TypeVar

from stucksolver.plan import Observation
from stucksolver.scene import ControlKind, LightState, ObjectKind, Scene, Surroundings, TrafficControl
from stucksolver.scene.objects import STATIC_KINDS, TrackedObject

DISPUTE_DURATION_S = 30.0
"""Longer than three looks at the image by a model that takes 10 s; after that perception is believed again."""
LIGHT = "light"
"""The key of the light ahead among the ids of objects; no stack gives an object this id."""
CONTRADICTED = STATIC_KINDS - {ObjectKind.CROSSING_GATE}
"""Kinds that allow something: some may be driven over, and all are assumed not to move. (A gate forbids.)"""
SHOWN = frozenset({LightState.GREEN, LightState.OFF})
"""Light states that allow something."""
EQUIVALENT_KINDS = (
    frozenset({ObjectKind.CAR, ObjectKind.VAN, ObjectKind.TRUCK, ObjectKind.BUS}),
    frozenset({ObjectKind.BAG, ObjectKind.LITTER}),
    frozenset({ObjectKind.DEBRIS, ObjectKind.PROP}),
)
"""Kinds that are treated alike: confusing them is no contradiction."""

Told = TypeVar("Told", bound=TrackedObject)


class Disagreement(NamedTuple):
    """One contradiction. `key` is the object's id or `LIGHT`."""

    key: str
    perceived: str
    said: str
    counts: bool
    """True if the object counts as unknown from now on. False if what was perceived already forbids."""

    def __str__(self) -> str:
        what = "the light" if self.key == LIGHT else f"object {self.key}"
        end = "; it counts as unknown" if self.counts else ""
        return f"perception says that {what} is {self.perceived}, the reasoner sees {self.said}{end}"


def find_disagreements(scene: Scene, said: Observation) -> tuple[Disagreement, ...]:
    """Return where an observation contradicts its scene; empty if the reasoner had no image."""
    if scene.image is None:
        return ()
    kinds = {obj.id: obj.kind for obj in scene.objects}
    found = [
        Disagreement(
            participant.object_id,
            kinds[participant.object_id].value,
            participant.kind.value,
            kinds[participant.object_id] in CONTRADICTED,
        )
        for participant in said.participants
        if participant.object_id in kinds and _contradict(kinds[participant.object_id], participant.kind)
    ]
    light = next((control for control in scene.controls if control.kind is ControlKind.TRAFFIC_LIGHT), None)
    seen = {
        control.state
        for control in said.controls
        if control.kind is ControlKind.TRAFFIC_LIGHT and control.applies is not False
    }
    seen -= {None, LightState.UNKNOWN}
    known = light is not None and light.state not in (None, LightState.UNKNOWN)
    if light is not None and light.state is not None and known and seen and seen != {light.state}:
        words = " and ".join(sorted(item.value for item in seen if item is not None))
        found.append(Disagreement(LIGHT, light.state.value, words, light.state in SHOWN))
    return tuple(found)


def update_disputes(doubts: Mapping[str, float], found: tuple[Disagreement, ...], now_s: float) -> Mapping[str, float]:
    """Return the doubts now in force, each with the time at which it ends (s, the solver's own time)."""
    kept = {key: until_s for key, until_s in doubts.items() if until_s > now_s}
    return MappingProxyType({**kept, **{item.key: now_s + DISPUTE_DURATION_S for item in found if item.counts}})


def mask_disputed(seen: Surroundings, doubts: Mapping[str, float], now_s: float) -> Surroundings:
    """Return the surroundings with doubted objects as unknown, or the same object if nothing is doubted."""
    held = _in_force(doubts, now_s)
    if not held:
        return seen
    return seen.model_copy(update={"objects": _objects(seen.objects, held), "controls": _controls(seen.controls, held)})


def mask_disputed_scene(scene: Scene, doubts: Mapping[str, float], now_s: float) -> Scene:
    """Return the scene for reasoners with doubted objects as unknown."""
    held = _in_force(doubts, now_s)
    if not held:
        return scene
    update = {"objects": _objects(scene.objects, held), "controls": _controls(scene.controls, held)}
    return scene.model_copy(update=update)


def _contradict(perceived: ObjectKind, said: ObjectKind) -> bool:
    if ObjectKind.UNKNOWN in (perceived, said) or perceived is said:
        return False
    return not any({perceived, said} <= alike for alike in EQUIVALENT_KINDS)


def _in_force(doubts: Mapping[str, float], now_s: float) -> frozenset[str]:
    return frozenset(key for key, until_s in doubts.items() if until_s > now_s)


def _objects(objects: tuple[Told, ...], held: frozenset[str]) -> tuple[Told, ...]:
    return tuple(
        obj.model_copy(update={"kind": ObjectKind.UNKNOWN}) if obj.id in held and obj.kind in CONTRADICTED else obj
        for obj in objects
    )


def _controls(controls: tuple[TrafficControl, ...], held: frozenset[str]) -> tuple[TrafficControl, ...]:
    return tuple(
        control.model_copy(update={"state": LightState.UNKNOWN})
        if LIGHT in held and control.state in SHOWN
        else control
        for control in controls
    )
