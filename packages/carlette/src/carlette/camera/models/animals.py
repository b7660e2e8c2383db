"""Animals: four-legged ones of any size, and a goose."""

from __future__ import annotations

import math
from dataclasses import dataclass

from carlette.camera.models.mesh import Builder, Color, Mesh, Point, shade
from carlette.geometry import Box


@dataclass(frozen=True)
class Breed:
    """Colors and proportions of a four-legged animal, in its length and height."""

    coat: Color
    muzzle: Color
    legs: float
    """Length of the legs, as a share of the height at the head."""
    neck: float
    """Height of the head above the back, as a share of the height."""
    spots: Color | None = None
    antlers: bool = False
    mane: Color | None = None


BREEDS = {
    "animal.cat": Breed((176, 120, 62), (226, 206, 180), 0.42, 0.16),
    "animal.dog": Breed((150, 104, 60), (60, 46, 38), 0.46, 0.20),
    "animal.deer": Breed((160, 108, 66), (70, 52, 42), 0.48, 0.30, antlers=True),
    "animal.cow": Breed((238, 234, 228), (226, 178, 170), 0.42, 0.10, spots=(34, 30, 28)),
    "animal.horse": Breed((122, 76, 46), (60, 42, 34), 0.48, 0.28, mane=(40, 28, 22)),
}


def animal_mesh(type_id: str, box: Box, phase: float, share: float) -> Mesh:
    """Return an animal in the frame of its actor (the middle of its body); legs swung to `phase`."""
    builder = Builder()
    if type_id == "animal.goose":
        _goose(builder, box, phase, share)
    else:
        _four_legs(builder, BREEDS.get(type_id, BREEDS["animal.dog"]), box, phase, share)
    return builder.mesh()


def _four_legs(builder: Builder, breed: Breed, box: Box, phase: float, share: float) -> None:
    (hx, hy, hz), bottom = box.extent, box.center.z - box.extent.z
    height = 2 * hz * (0.86 if breed.antlers else 1.0)
    back = bottom + height * (1.0 - breed.neck)
    belly = bottom + height * breed.legs
    half = min(hy * 0.85, 0.32 * (back - belly) + 0.1)
    tail, chest = -hx * 0.80, hx * 0.48
    builder.loft(
        (
            (tail, belly + 0.08 * height, back - 0.03 * height, half * 0.7, half * 0.5),
            (tail * 0.6, belly, back, half, half * 0.66),
            (chest * 0.6, belly - 0.02 * height, back - 0.02 * height, half, half * 0.66),
            (chest, belly + 0.06 * height, back + 0.02 * height, half * 0.6, half * 0.4),
        ),
        breed.coat,
    )
    builder.plate((-0.1 * hx, 0.0, belly), (1.2 * hx, 1.4 * half), (0, 0, -1.0), shade(breed.coat, 0.8))
    for x, sign in ((chest * 0.82, 1.0), (tail * 0.84, -1.0)):
        for side in (1.0, -1.0):
            swing = math.sin(2 * math.pi * phase + (0 if sign * side > 0 else math.pi)) * share * 0.22 * height
            foot = (x + swing, side * half * 0.62, bottom)
            builder.limb(
                foot, (x, side * half * 0.62, belly + 0.1 * height), half * 0.34, half * 0.42, shade(breed.coat, 0.9)
            )
    _head_of(builder, breed, (chest, hx, back, bottom + height), half)
    builder.limb(
        (tail - 0.12 * hx, 0.0, belly + 0.1 * height),
        (tail, 0.0, back - 0.04 * height),
        half * 0.2,
        half * 0.2,
        breed.mane or shade(breed.coat, 0.8),
    )
    for number, (x, z) in enumerate(((-0.35, 0.62), (0.1, 0.4), (-0.1, 0.8)) if breed.spots else ()):
        for side in (1.0, -1.0):
            builder.disc(
                (x * hx, side * (half + 0.012), belly + z * (back - belly)),
                0.24 * (back - belly) * (1 + 0.3 * number),
                (0, side, 0.0),
                breed.spots or breed.coat,
                sides=7,
            )


def _head_of(builder: Builder, breed: Breed, place: tuple[float, float, float, float], half: float) -> None:
    chest, front, back, top = place
    size = max(0.5 * half, 0.05)
    x, z = front - 1.9 * size, top - 1.1 * size
    builder.limb(
        (chest - 0.3 * half, 0.0, back - 0.4 * half), (x, 0.0, z - 0.2 * size), half * 0.62, half * 0.8, breed.coat
    )
    builder.loft(
        (
            (x - 0.7 * size, z - 0.7 * size, z + 0.8 * size, 0.75 * size, 0.6 * size),
            (x + 0.4 * size, z - 0.7 * size, z + 0.6 * size, 0.7 * size, 0.5 * size),
            (x + 1.8 * size, z - 0.75 * size, z - 0.05 * size, 0.45 * size, 0.35 * size),
        ),
        breed.coat,
    )
    builder.plate((x + 1.82 * size, 0.0, z - 0.4 * size), (0.8 * size, 0.6 * size), (1.0, 0, 0), breed.muzzle)
    for side in (1.0, -1.0):
        builder.limb(
            (x - 0.3 * size, side * 0.5 * size, z + 0.6 * size),
            (x - 0.4 * size, side * 0.8 * size, z + 1.3 * size),
            0.25 * size,
            0.2 * size,
            shade(breed.coat, 0.8),
        )
        builder.plate(
            (x + 0.5 * size, side * 0.66 * size, z + 0.2 * size), (0.24 * size, 0.2 * size), (0, side, 0), (16, 14, 14)
        )
        if breed.antlers:
            tip = (x - 0.6 * size, side * 2.0 * size, z + 3.6 * size)
            fork = (x - 0.6 * size, side * 1.4 * size, z + 2.2 * size)
            for a, b in (
                ((x - 0.3 * size, side * 0.3 * size, z + 0.6 * size), fork),
                (fork, tip),
                (fork, (x + 0.6 * size, side * 1.5 * size, z + 3.0 * size)),
            ):
                builder.limb(a, b, 0.22 * size, 0.22 * size, (206, 186, 150))
    if breed.mane:
        builder.limb(
            (chest - 0.4 * half, 0.0, back + 0.1), (x - 0.6 * size, 0.0, z + 0.7 * size), 0.06, 0.14, breed.mane
        )


def _goose(builder: Builder, box: Box, phase: float, share: float) -> None:
    (hx, hy, hz), bottom = box.extent, box.center.z - box.extent.z
    white: Color = (240, 240, 236)
    orange: Color = (244, 140, 30)
    builder.loft(
        (
            (-hx, bottom + 0.85 * hz, bottom + 1.0 * hz, 0.02, 0.02),
            (-0.4 * hx, bottom + 0.45 * hz, bottom + 1.15 * hz, hy * 0.8, hy * 0.5),
            (0.3 * hx, bottom + 0.45 * hz, bottom + 1.1 * hz, hy * 0.7, hy * 0.4),
            (0.55 * hx, bottom + 0.6 * hz, bottom + 0.95 * hz, hy * 0.3, hy * 0.2),
        ),
        white,
    )
    neck: Point = (0.62 * hx, 0.0, bottom + 1.85 * hz)
    builder.limb((0.42 * hx, 0.0, bottom + 0.8 * hz), neck, 0.07, 0.08, white)
    builder.box((neck[0] + 0.03, 0.0, neck[2]), (0.14, 0.08, 0.09), white)
    builder.box((neck[0] + 0.14, 0.0, neck[2] - 0.01), (0.1, 0.05, 0.04), orange)
    for side in (1.0, -1.0):
        swing = math.sin(2 * math.pi * phase + (0 if side > 0 else math.pi)) * share * 0.08
        builder.limb((swing, side * 0.08, bottom), (0.0, side * 0.08, bottom + 0.5 * hz), 0.035, 0.035, orange)
        builder.box((swing + 0.04, side * 0.08, bottom + 0.015), (0.13, 0.09, 0.03), orange)
