"""Small props on the ground: boxes, bags, stones, papers."""

from __future__ import annotations

import itertools
import math
from random import Random

from carlette.camera.models.mesh import Builder, Color, Point, shade
from carlette.camera.models.palette import CARTON, EIGHT, RING, low_of
from carlette.camera.models.signs import RED, UP, WHITE
from carlette.geometry import Box


def carton(builder: Builder, box: Box, name: str) -> None:
    """Build a cardboard box with its tape."""
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
    builder.box(box.center, (2 * hx, 2 * hy, 2 * hz), CARTON)
    builder.plate((cx, cy, low + 2 * hz + 0.004), (0.14 * hx, 2 * hy), (0, 0, 1.0), (222, 200, 150))
    for side in (1.0, -1.0):
        builder.plate(
            (cx + side * (hx + 0.004), cy, low + 1.6 * hz), (0.16 * hy, 0.8 * hz), (side, 0, 0), (222, 200, 150)
        )
        builder.plate(
            (cx, cy + side * (hy + 0.004), low + 0.7 * hz), (0.5 * hx, 0.4 * hz), (0, side, 0), (240, 236, 226)
        )


def paper_bag(builder: Builder, box: Box, name: str) -> None:
    """Build brown paper with two handles, open and a little crumpled at the top."""
    del name
    (hx, hy, hz), low = box.extent, low_of(box)
    top = low + 1.6 * hz
    base: list[Point] = [(hx * a * 0.9, hy * b * 0.94, low) for a, b in RING]
    waist: list[Point] = [(hx * a, hy * b, low + 0.9 * hz) for a, b in RING]
    rim: list[Point] = [(hx * a * 0.84 + 0.01 * b, hy * b * 0.97, top - 0.02 * (a * b > 0)) for a, b in RING]
    builder.hull(base, waist, (190, 146, 92))
    builder.hull(waist, rim, (206, 164, 108), (84, 60, 38))
    for side in (0.8, -0.8):
        ends = [
            (side * hx, part * hy, z)
            for part, z in ((-0.45, top - 0.02), (-0.3, low + 1.97 * hz), (0.3, low + 1.97 * hz), (0.45, top - 0.02))
        ]
        for end, other in itertools.pairwise(ends):
            builder.limb(end, other, 0.018, 0.018, (150, 108, 62))
    for side in (1.0, -1.0):
        builder.face(
            [
                (side * (hx + 0.004), -0.5 * hy, low + 0.9 * hz),
                (side * (hx * 0.86 + 0.004), 0.0, top - 0.03),
                (side * (hx + 0.004), 0.5 * hy, low + 0.9 * hz),
            ],
            (176, 134, 82),
            (side, 0, 0),
        )


def bag(builder: Builder, box: Box, name: str) -> None:
    """Build a full bag, tied at the top."""
    color: Color = (30, 32, 34) if "trash" in name else ((236, 240, 244) if "plastic" in name else (190, 60, 70))
    (hx, hy, hz), low = box.extent, low_of(box)
    levels = ((0.0, 0.75), (0.35, 1.0), (0.7, 0.7), (0.85, 0.2), (1.0, 0.42))
    for (a, r0), (b, r1) in itertools.pairwise(levels):
        item: list[Point] = [(hx * r0 * math.cos(t), hy * r0 * math.sin(t), low + 2 * hz * a) for t in EIGHT]
        two: list[Point] = [(hx * r1 * math.cos(t + 0.1), hy * r1 * math.sin(t + 0.1), low + 2 * hz * b) for t in EIGHT]
        builder.hull(item, two, shade(color, 0.85 + 0.3 * a))


def rock(builder: Builder, box: Box, name: str) -> None:
    """Build an irregular boulder."""
    random = Random(name)
    (hx, hy, hz), low = box.extent, low_of(box)
    gray: Color = (128, 124, 118)
    levels = ((0.0, 0.86), (0.35, 1.0), (0.75, 0.74), (1.0, 0.30))
    rings: list[list[Point]] = []
    for rise, r in levels:
        spread = [random.uniform(0.82, 1.0) for _ in EIGHT]
        rings.append(
            [
                (hx * r * k * math.cos(t), hy * r * k * math.sin(t), low + 2 * hz * rise)
                for t, k in zip(EIGHT, spread, strict=True)
            ]
        )
    for number, (ring, two) in enumerate(itertools.pairwise(rings)):
        builder.hull(ring, two, shade(gray, 0.9 + 0.1 * number))


def rubble(builder: Builder, box: Box, name: str) -> None:
    """Build heaps of dirt and stones, flat on the road."""
    random = Random(name)
    (hx, hy, hz), low = box.extent, low_of(box)
    for number in range(4):
        x, y = random.uniform(-0.45, 0.45) * hx, random.uniform(-0.45, 0.45) * hy
        r = random.uniform(0.4, 0.6)
        item: list[Point] = [(x + hx * r * math.cos(t), y + hy * r * math.sin(t), low) for t in EIGHT]
        two: list[Point] = [
            (x + 0.4 * hx * r * math.cos(t), y + 0.4 * hy * r * math.sin(t), low + 2 * hz * random.uniform(0.5, 1.0))
            for t in EIGHT
        ]
        builder.hull(item, two, shade((118, 92, 66), 0.85 + 0.1 * number))
    for _ in range(16):
        x, y, size = random.uniform(-0.95, 0.95) * hx, random.uniform(-0.95, 0.95) * hy, random.uniform(0.05, 0.13)
        builder.box(
            (x, y, low + size / 2),
            (size, size * 1.3, size),
            shade((140, 132, 122), random.uniform(0.7, 1.1)),
            random.uniform(0, 90),
        )


def ball(builder: Builder, box: Box, name: str) -> None:
    """Build a ball in two colors."""
    del name
    r, (cx, cy, cz) = box.extent.z, box.center
    levels = ((-1.0, 0.3), (-0.5, 0.87), (0.0, 1.0), (0.5, 0.87), (1.0, 0.3))
    for number, ((a, r0), (b, r1)) in enumerate(itertools.pairwise(levels)):
        builder.cylinder(
            (cx, cy, cz + a * r), (cx, cy, cz + b * r), r0 * r, (WHITE, RED)[number % 2], sides=8, tip=r1 * r
        )


def tyre(builder: Builder, box: Box, name: str) -> None:
    """Build a tire that lies flat."""
    del name
    low = low_of(box)
    builder.cylinder((0, 0, low), (0, 0, low + 2 * box.extent.z), box.extent.x, (28, 28, 30), sides=14)
    builder.cylinder(
        (0, 0, low + 2 * box.extent.z),
        (0, 0, low + 2 * box.extent.z + 0.004),
        0.55 * box.extent.x,
        (74, 70, 64),
        sides=10,
    )


def paper(builder: Builder, box: Box, name: str) -> None:
    """Build a creased sheet."""
    (hx, hy, hz), low = box.extent, low_of(box)
    color: Color = (240, 238, 230) if name == "paper" else CARTON
    random = Random(name)
    ring: list[Point] = [(hx * a, hy * b, low + 2 * hz * random.uniform(0.3, 1.0) + 0.012) for a, b in RING]
    builder.face([ring[0], ring[1], ring[2]], color, UP)
    builder.face([ring[0], ring[2], ring[3]], shade(color, 0.92), UP)
    builder.face([ring[0], ring[1], ring[2]], color, (0, 0, -1.0))


def bale(builder: Builder, box: Box, name: str) -> None:
    """Build a round bale of hay."""
    del name
    (hx, hy, hz), (cx, cy, cz) = box.extent, box.center
    builder.cylinder((cx, cy - hy, cz), (cx, cy + hy, cz), min(hx, hz), (212, 178, 92), sides=14, cap=(186, 150, 74))


def loose_door(builder: Builder, box: Box, name: str) -> None:
    """Build a detached car door that is upright."""
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
    builder.box((cx, cy, low + 0.6 * hz), (2 * hx, 2 * hy, 1.2 * hz), (120, 124, 130))
    builder.box((cx - 0.1 * hx, cy, low + 1.6 * hz), (1.6 * hx, hy, 0.8 * hz), (60, 74, 86))
    del name
