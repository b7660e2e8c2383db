"""Where a reasoner that looks at the picture contradicts perception: what things are then no longer taken for.

A doubt only takes away. Perception's word grants something where a thing is said to be soft or not to move, and where
a light is said to be green or off; contradicted, it counts as unknown for a while. What forbids (a person, a vehicle, a
school bus, a red light) is not changed by anything a model says, and no model's word makes a thing harmless.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple, TypeVar

from stucksolver.decision import Observation
from stucksolver.scene import ControlKind, LightState, ObjectKind, Scene, Surroundings, TrafficControl
from stucksolver.scene.objects import STATIC_KINDS, TrackedObject

DOUBTED_S = 30.0
"""Longer than three looks at the picture by a model that takes 10 s; after that perception is believed again."""
LIGHT = "light"
"""Stands for the light ahead, among the ids of objects; no stack has an object of this name."""
CONTRADICTED = STATIC_KINDS - {ObjectKind.CROSSING_GATE}
"""Kinds that grant something: some may be driven over, all are held not to move. (A gate forbids.)"""
SHOWN = frozenset({LightState.GREEN, LightState.OFF})
"""States that grant something."""
ALIKE = (
    frozenset({ObjectKind.CAR, ObjectKind.VAN, ObjectKind.TRUCK, ObjectKind.BUS}),
    frozenset({ObjectKind.BAG, ObjectKind.LITTER}),
    frozenset({ObjectKind.DEBRIS, ObjectKind.PROP}),
)
"""Kinds that are treated alike: to take one for the other is no contradiction."""

Told = TypeVar("Told", bound=TrackedObject)


class Disagreement(NamedTuple):
    """One contradiction; `key` is the object's id or `LIGHT`."""

    key: str
    perceived: str
    said: str
    counts: bool
    """Is it taken for unknown from now on? False where what was perceived forbids already."""

    def __str__(self) -> str:
        what = "the light" if self.key == LIGHT else f"object {self.key}"
        end = "; it counts as unknown" if self.counts else ""
        return f"perception says that {what} is {self.perceived}, the reasoner sees {self.said}{end}"


def disagreements(scene: Scene, said: Observation) -> tuple[Disagreement, ...]:
    """What an observation contradicts in the scene that it is of; nothing where the reasoner had no picture."""
    if scene.image is None:
        return ()
    kinds = {one.id: one.kind for one in scene.objects}
    found = [
        Disagreement(one.object_id, kinds[one.object_id].value, one.kind.value, kinds[one.object_id] in CONTRADICTED)
        for one in said.participants
        if one.object_id in kinds and _contradict(kinds[one.object_id], one.kind)
    ]
    light = next((one for one in scene.controls if one.kind is ControlKind.TRAFFIC_LIGHT), None)
    seen = {one.state for one in said.controls if one.kind is ControlKind.TRAFFIC_LIGHT and one.applies is not False}
    seen -= {None, LightState.UNKNOWN}
    known = light is not None and light.state not in (None, LightState.UNKNOWN)
    if light is not None and light.state is not None and known and seen and seen != {light.state}:
        words = " and ".join(sorted(one.value for one in seen if one is not None))
        found.append(Disagreement(LIGHT, light.state.value, words, light.state in SHOWN))
    return tuple(found)


def noted(doubts: Mapping[str, float], found: tuple[Disagreement, ...], now_s: float) -> Mapping[str, float]:
    """The doubts in force from now on, each with the time at which it ends."""
    kept = {key: until_s for key, until_s in doubts.items() if until_s > now_s}
    return MappingProxyType({**kept, **{one.key: now_s + DOUBTED_S for one in found if one.counts}})


def doubted(seen: Surroundings, doubts: Mapping[str, float], now_s: float) -> Surroundings:
    """The surroundings with what is doubted as unknown; the same object where nothing in it is."""
    held = _in_force(doubts, now_s)
    if not held:
        return seen
    return seen.model_copy(update={"objects": _objects(seen.objects, held), "controls": _controls(seen.controls, held)})


def doubted_scene(scene: Scene, doubts: Mapping[str, float], now_s: float) -> Scene:
    """The same for what reasoners are told."""
    held = _in_force(doubts, now_s)
    if not held:
        return scene
    update = {"objects": _objects(scene.objects, held), "controls": _controls(scene.controls, held)}
    return scene.model_copy(update=update)


def _contradict(perceived: ObjectKind, said: ObjectKind) -> bool:
    if ObjectKind.UNKNOWN in (perceived, said) or perceived is said:
        return False
    return not any({perceived, said} <= alike for alike in ALIKE)


def _in_force(doubts: Mapping[str, float], now_s: float) -> frozenset[str]:
    return frozenset(key for key, until_s in doubts.items() if until_s > now_s)


def _objects(objects: tuple[Told, ...], held: frozenset[str]) -> tuple[Told, ...]:
    return tuple(
        one.model_copy(update={"kind": ObjectKind.UNKNOWN}) if one.id in held and one.kind in CONTRADICTED else one
        for one in objects
    )


def _controls(controls: tuple[TrafficControl, ...], held: frozenset[str]) -> tuple[TrafficControl, ...]:
    return tuple(
        one.model_copy(update={"state": LightState.UNKNOWN}) if LIGHT in held and one.state in SHOWN else one
        for one in controls
    )
