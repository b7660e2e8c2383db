"""People on foot and on two wheels, built around their joints."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from random import Random

from carlette.camera.models.lettering import lettering
from carlette.camera.models.mesh import Builder, Color, Mesh, Point, shade
from carlette.camera.models.signs import stop_face

SKINS: tuple[Color, ...] = ((236, 196, 168), (214, 166, 130), (170, 122, 90), (116, 80, 58))
HAIRS: tuple[Color, ...] = ((44, 34, 28), (88, 62, 42), (190, 156, 96), (120, 116, 112), (140, 70, 40))
TOPS: tuple[Color, ...] = (
    (196, 50, 46), (46, 92, 170), (236, 236, 232), (60, 128, 76), (240, 190, 60), (128, 70, 140), (70, 74, 84),
    (226, 120, 40),
)  # fmt: skip
TROUSERS: tuple[Color, ...] = ((40, 52, 84), (60, 60, 66), (116, 98, 76), (28, 28, 32), (90, 100, 120))
SHOES: Color = (34, 30, 30)
VEST: Color = (226, 255, 40)
ORANGE: Color = (255, 118, 10)
Joints = Mapping[str, Point]


@dataclass(frozen=True)
class Clothes:
    """Colors of one person."""

    skin: Color
    hair: Color
    top: Color
    trousers: Color
    long_hair: bool = False
    skirt: bool = False
    hat: Color | None = None


def clothes_of(type_id: str, gender: str, age: str) -> Clothes:
    """Return the clothes of a person; always the same for the same blueprint."""
    random = Random(f"{type_id} {age}")
    female = gender == "female"
    return Clothes(
        random.choice(SKINS), random.choice(HAIRS), random.choice(TOPS), random.choice(TROUSERS), female,
        female and random.random() < 0.3,
    )  # fmt: skip


def person(joints: Joints, height_m: float, clothes: Clothes, paddle: str = "") -> Mesh:
    """Return a person in the frame of its actor. `joints` as in `world.skeleton` (names without the rig's prefix).

    `paddle` is the sign in a flagger's right hand: `stop`, `slow` or nothing.
    """
    builder = Builder()
    h = height_m
    hips, neck, head = joints["hips__C"], joints["neck__C"], joints["Head__C"]
    width = 0.20 * h if h > 1.4 else 0.22 * h
    _torso(builder, hips, neck, width, h, clothes)
    for side in ("L", "R"):
        thigh, knee, foot, toe = (joints[f"{item}__{side}"] for item in ("thigh", "leg", "foot", "toe"))
        leg = clothes.skin if clothes.skirt else clothes.trousers
        builder.limb(_up(knee, 0.0), _up(thigh, 0.02 * h), 0.085 * h, 0.10 * h, leg)
        builder.limb(_up(foot, 0.01 * h), knee, 0.065 * h, 0.075 * h, shade(leg, 0.94))
        builder.box(((foot[0] + toe[0]) / 2 + 0.01, foot[1], foot[2] - 0.005), (0.15 * h, 0.06 * h, 0.05 * h), SHOES)
        shoulder, elbow, hand = (joints[f"{item}__{side}"] for item in ("arm", "foreArm", "hand"))
        builder.limb(elbow, shoulder, 0.055 * h, 0.06 * h, clothes.top)
        builder.limb(hand, elbow, 0.045 * h, 0.05 * h, shade(clothes.top, 0.92))
        builder.box(hand, (0.06 * h, 0.05 * h, 0.06 * h), clothes.skin)
    _head(builder, head, h, clothes)
    if paddle:
        _paddle(builder, joints["hand__R"], h, paddle)
    return builder.mesh()


def _torso(builder: Builder, hips: Point, neck: Point, width: float, h: float, clothes: Clothes) -> None:
    depth = 0.12 * h
    ring = ((1, 1), (1, -1), (-1, -1), (-1, 1))
    low: list[Point] = [(hips[0] + x * depth * 0.48, hips[1] + y * width * 0.44, hips[2] - 0.03 * h) for x, y in ring]
    waist: list[Point] = [(hips[0] + x * depth * 0.44, hips[1] + y * width * 0.42, hips[2] + 0.09 * h) for x, y in ring]
    chest: list[Point] = [(neck[0] + x * depth * 0.5, neck[1] + y * width * 0.58, neck[2] - 0.05 * h) for x, y in ring]
    collar: list[Point] = [(neck[0] + x * depth * 0.3, neck[1] + y * width * 0.26, neck[2]) for x, y in ring]
    if clothes.skirt:
        hem: list[Point] = [(hips[0] + x * depth * 0.9, hips[1] + y * width * 0.72, hips[2] - 0.2 * h) for x, y in ring]
        builder.hull(hem, waist, clothes.trousers)
    else:
        builder.hull(low, waist, clothes.trousers)
    builder.hull(waist, chest, clothes.top)
    builder.hull(chest, collar, clothes.top)
    if clothes.top == VEST:
        middle = ((waist[0][0] + chest[0][0]) / 2, hips[1], (waist[0][2] + chest[0][2]) / 2)
        for z in (-0.04 * h, 0.06 * h):
            builder.box((neck[0], middle[1], middle[2] + z), (depth * 1.08, width * 1.08, 0.03 * h), (236, 238, 240))


def _head(builder: Builder, head: Point, h: float, clothes: Clothes) -> None:
    size = 0.066 * h if h > 1.4 else 0.085 * h
    x, y, z = head[0] + 0.01 * h, head[1], head[2] + 0.035 * h
    builder.cylinder(
        (x - 0.01, y, head[2] - 0.07 * h), (x - 0.01, y, z - 0.4 * size), 0.032 * h, shade(clothes.skin, 0.85), sides=6
    )
    rings = ((-1.0, 0.62), (-0.35, 0.98), (0.45, 1.0), (1.05, 0.62))
    for (low, r0), (high, r1) in itertools.pairwise(rings):
        builder.cylinder(
            (x, y, z + low * size), (x, y, z + high * size), r0 * size, clothes.skin, sides=8, tip=r1 * size
        )
    for side in (0.36, -0.36):
        builder.plate(
            (x + 0.97 * size, y + side * size, z + 0.15 * size), (0.22 * size, 0.16 * size), (1.0, 0, 0), (30, 26, 26)
        )
    cover = clothes.hat or clothes.hair
    builder.cylinder(
        (x - 0.12 * size, y, z + 0.42 * size),
        (x - 0.12 * size, y, z + 1.22 * size),
        1.1 * size,
        cover,
        sides=8,
        tip=0.66 * size,
    )
    if clothes.hat:
        builder.cylinder(
            (x + 0.1 * size, y, z + 0.42 * size), (x + 0.1 * size, y, z + 0.52 * size), 1.36 * size, cover, sides=8
        )
    else:
        builder.box(
            (x - 0.68 * size, y, z - (0.5 if clothes.long_hair else 0.0) * size),
            (0.75 * size, 1.9 * size, (2.3 if clothes.long_hair else 1.2) * size),
            clothes.hair,
        )


def _paddle(builder: Builder, hand: Point, h: float, word: str) -> None:
    """Build a stop or slow sign on a stick, its face ahead."""
    x, y, z = hand[0] + 0.06 * h, hand[1], hand[2]
    builder.cylinder((x, y, z - 0.25), (x, y, z + 0.50), 0.018, (200, 190, 170), sides=5)
    middle = (x + 0.03, y, z + 0.72)
    if word == "stop":
        stop_face(builder, middle, 0.32)
        return
    points = [(x + 0.02, y + a * 0.36, z + 0.72 + b * 0.36) for a, b in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    builder.face(points, (255, 140, 10), (1.0, 0, 0))
    builder.face([(x - 0.02, p[1], p[2]) for p in points], (255, 140, 10), (-1.0, 0, 0))
    lettering(builder, "SLOW", (x + 0.04, y, z + 0.72), (0, -1.0, 0), (0, 0, 1.0), 0.15, (10, 10, 10), width_m=0.44)


def _up(point: Point, rise: float) -> Point:
    return (point[0], point[1], point[2] + rise)


def stride(joints: dict[str, Point], phase: float, share: float, height_m: float) -> dict[str, Point]:
    """Return the joints of a walking person: limbs swung to `phase` (in double steps), at `share` of the full
    stride.
    """
    moved = dict(joints)
    for side, sign in (("L", 1.0), ("R", -1.0)):
        swing = sign * math.sin(2 * math.pi * phase) * share
        lift = max(0.0, sign * math.cos(2 * math.pi * phase)) * share
        for name, ahead, rise in (
            ("leg", 0.12, 0.03 * lift), ("foot", 0.22, 0.07 * lift), ("toe", 0.22, 0.07 * lift),
            ("foreArm", -0.07, 0.0), ("hand", -0.16, 0.03 * abs(swing)),
        ):  # fmt: skip
            x, y, z = joints[f"{name}__{side}"]
            moved[f"{name}__{side}"] = (x + swing * ahead * height_m, y, z + rise * height_m)
        x, y, z = moved[f"foot__{side}"]
        moved[f"foot__{side}"] = (x - 0.05 * height_m * lift, y, z)
    return moved
