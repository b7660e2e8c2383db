"""Where the joints of a standing walker are. Limbs do not swing: each joint keeps its place in the body."""

from __future__ import annotations

from typing import NamedTuple

from carlette.geometry import Pose, Vector

_MIDDLE: dict[str, tuple[str, float]] = {
    "crl_root": ("", 0.0),
    "crl_hips__C": ("crl_root", 0.53),
    "crl_spine__C": ("crl_hips__C", 0.60),
    "crl_spine01__C": ("crl_spine__C", 0.70),
    "crl_neck__C": ("crl_spine01__C", 0.84),
    "crl_Head__C": ("crl_neck__C", 0.90),
}
"""Bone to its parent and its height, as a part of the body's."""
_SIDES: dict[str, tuple[str, float, float, float]] = {
    "crl_shoulder": ("crl_spine01__C", 0.0, 0.04, 0.81),
    "crl_arm": ("crl_shoulder", 0.0, 0.11, 0.81),
    "crl_foreArm": ("crl_arm", 0.0, 0.13, 0.63),
    "crl_hand": ("crl_foreArm", 0.02, 0.14, 0.48),
    "crl_thigh": ("crl_hips__C", 0.0, 0.05, 0.51),
    "crl_leg": ("crl_thigh", 0.0, 0.05, 0.28),
    "crl_foot": ("crl_leg", 0.0, 0.05, 0.04),
    "crl_toe": ("crl_foot", 0.07, 0.05, 0.01),
    "crl_eye": ("crl_Head__C", 0.05, 0.02, 0.94),
}
"""The same for both sides, with the distance ahead of and beside the middle."""


class Bone(NamedTuple):
    """One joint: its pose in the world, in the walker's frame and in its parent bone's."""

    name: str
    world: Pose
    component: Pose
    relative: Pose


def bones(walker: Pose, half_height_m: float) -> list[Bone]:
    """All joints of a walker whose origin is at half its height, parents first."""
    places = {"": Vector(z=-half_height_m)}
    found = []
    for name, parent, place in _joints(2.0 * half_height_m):
        here = places[name] = place.plus(Vector(z=-half_height_m))
        above = places[parent]
        relative = Vector(here.x - above.x, here.y - above.y, here.z - above.z)
        found.append(Bone(name, Pose(walker.apply(here), walker.rotation), Pose(here), Pose(relative)))
    return found


def _joints(height_m: float) -> list[tuple[str, str, Vector]]:
    middle = [(name, parent, Vector(z=part * height_m)) for name, (parent, part) in _MIDDLE.items()]
    for side, right in (("__L", -1.0), ("__R", 1.0)):
        for name, (parent, ahead, beside, up) in _SIDES.items():
            above = parent if parent.endswith("__C") else parent + side
            place = Vector(ahead * height_m, right * beside * height_m, up * height_m)
            middle.append((name + side, above, place))
    return middle
