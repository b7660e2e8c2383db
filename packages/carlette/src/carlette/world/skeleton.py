"""The joints of a walker: standing, or in the pose that a client or a gesture sets.

Limbs do not swing while the walker moves.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from carlette.geometry import Pose, Rotation, Vector

_MIDDLE: dict[str, tuple[str, float]] = {
    "crl_root": ("", 0.0),
    "crl_hips__C": ("crl_root", 0.53),
    "crl_spine__C": ("crl_hips__C", 0.60),
    "crl_spine01__C": ("crl_spine__C", 0.70),
    "crl_neck__C": ("crl_spine01__C", 0.84),
    "crl_Head__C": ("crl_neck__C", 0.90),
}
"""Parent and height of each bone, as a share of the body's height. Ours."""
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
"""The same for both sides, with the distances ahead of and to the side of the center. Ours."""


class Bone(NamedTuple):
    """One joint: its pose in the world, in the walker's frame and in its parent bone's frame."""

    name: str
    world: Pose
    component: Pose
    relative: Pose


_FORWARD = Vector(0.18)
_SIDEWAYS = Vector(0.0, 0.18)
_LOW = Vector(0.15, 0.0, -0.1)
GESTURES: dict[str, dict[str, Vector]] = {
    "none": {},
    "stop": {"crl_foreArm__R": _FORWARD, "crl_hand__R": _FORWARD},
    "go": {"crl_foreArm__R": _SIDEWAYS, "crl_hand__R": _SIDEWAYS},
    "slow": {f"crl_{item}__{side}": _LOW for item in ("foreArm", "hand") for side in "LR"},
}
"""A flagger's gestures: the joints' positions relative to their parents, as shares of the body's height. Ours."""


def gesture(name: str, half_height_m: float) -> dict[str, Pose]:
    """Return the joints of a flagger's gesture, each in its parent's frame; none for an unknown name."""
    scale = 2.0 * half_height_m
    return {bone: Pose(Vector(*(scale * item for item in at))) for bone, at in GESTURES.get(name, {}).items()}


def bones(
    walker: Pose, half_height_m: float, posed: Mapping[str, Pose] | None = None, blend: float = 0.0
) -> list[Bone]:
    """Return all joints of a walker whose origin is at half its height, parents first.

    `posed` joints (in their parents' frames) are blended in with the share `blend`. They move their children.
    """
    usual = {"": Vector()}
    placed = {"": Pose(Vector(z=-half_height_m))}
    found = []
    for name, parent, place in _joints(2.0 * half_height_m):
        usual[name] = place
        above = usual[parent]
        relative = Pose(Vector(place.x - above.x, place.y - above.y, place.z - above.z))
        if posed and name in posed:
            relative = _between(relative, posed[name], blend)
        here = placed[name] = placed[parent].compose(relative)
        found.append(Bone(name, walker.compose(here), here, relative))
    return found


def _between(usual: Pose, posed: Pose, share: float) -> Pose:
    place, turn = (
        [a + (b - a) * share for a, b in zip(item, other, strict=True)]
        for item, other in zip(usual, posed, strict=True)
    )
    return Pose(Vector(*place), Rotation(*turn))


def _joints(height_m: float) -> list[tuple[str, str, Vector]]:
    middle = [(name, parent, Vector(z=part * height_m)) for name, (parent, part) in _MIDDLE.items()]
    for side, right in (("__L", -1.0), ("__R", 1.0)):
        for name, (parent, ahead, lateral, up) in _SIDES.items():
            above = parent if parent.endswith("__C") else parent + side
            place = Vector(ahead * height_m, right * lateral * height_m, up * height_m)
            middle.append((name + side, above, place))
    return middle


BONES = frozenset(name for name, _, _ in _joints(1.0))
"""Names of all joints."""
