"""Static props as meshes: by name where a thing has a form of its own, else a plain box of its size."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from random import Random

from carlette.camera.font import lettering
from carlette.camera.mesh import Builder, Color, Mesh, Point, shade
from carlette.camera.signs import RED, UP, WHITE
from carlette.geometry import Box

ORANGE: Color = (255, 96, 10)
CARTON: Color = (188, 142, 88)
WOOD: Color = (150, 106, 64)
STEEL: Color = (150, 154, 158)
GREEN: Color = (52, 110, 66)
DARK: Color = (44, 46, 50)
AMBER: Color = (255, 170, 10)


def prop_mesh(type_id: str, box: Box) -> Mesh:
    """A prop in its actor's frame; it fills its box."""
    builder = Builder()
    name = type_id.removeprefix("static.prop.")
    form = next((make for words, make in FORMS if any(word in name for word in words)), _plain)
    form(builder, box, name)
    return builder.mesh()


def _low(box: Box) -> float:
    return box.center.z - box.extent.z


def _cone(builder: Builder, box: Box, name: str) -> None:
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    radius = min(hx, hy)
    builder.box((cx, cy, low + 0.03), (2 * hx, 2 * hy, 0.06), (40, 40, 42) if name == "trafficcone01" else ORANGE)
    height = 2 * hz - 0.06
    cuts = ((0.0, 0.30, ORANGE), (0.30, 0.50, WHITE), (0.50, 0.68, ORANGE), (0.68, 0.84, WHITE), (0.84, 1.0, ORANGE))
    for a, b, color in cuts:
        r = (0.72 * radius * (1 - 0.86 * a), 0.72 * radius * (1 - 0.86 * b))
        builder.cylinder(
            (cx, cy, low + 0.06 + a * height), (cx, cy, low + 0.06 + b * height), r[0], color, sides=10, tip=r[1]
        )


def _barrier(builder: Builder, box: Box, name: str) -> None:
    """Two striped boards on feet; the wide side is the longer one."""
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    along_y = hy > hx
    half = max(hx, hy)
    for end in (-0.8, 0.8):
        at = (cx, cy + end * half) if along_y else (cx + end * half, cy)
        builder.box((at[0], at[1], low + hz), (0.07, 0.07, 2 * hz), STEEL)
        foot = (2 * hx, 0.1, 0.06) if along_y else (0.1, 2 * hy, 0.06)
        builder.box((at[0], at[1], low + 0.03), foot, DARK)
    for z in (0.80, 0.46):
        _striped(builder, (cx, cy, low + 2 * hz * z), half, 0.15 * hz, along_y)


def _striped(builder: Builder, middle: Point, half: float, high: float, along_y: bool, thick: float = 0.05) -> None:
    count = max(4, int(half / 0.14))
    for number in range(count):
        at = (2 * (number + 0.5) / count - 1) * half
        size = (thick, 2 * half / count, 2 * high) if along_y else (2 * half / count, thick, 2 * high)
        place = (middle[0], middle[1] + at, middle[2]) if along_y else (middle[0] + at, middle[1], middle[2])
        builder.box(place, size, RED if number % 2 else WHITE)


def _gate(builder: Builder, box: Box, name: str) -> None:
    del name
    _striped(builder, box.center, box.extent.y, box.extent.z, True, 2 * box.extent.x)
    for part in (-0.6, 0.0, 0.6, 0.96):
        builder.box(
            (box.center.x, box.center.y + part * box.extent.y, box.center.z - 0.12),
            (0.1, 0.1, 0.12),
            (255, 30, 20),
            glow=True,
        )


def _gate_post(builder: Builder, box: Box, name: str) -> None:
    del name
    low = _low(box)
    builder.box((0, 0, low + box.extent.z), (0.3, 0.3, 2 * box.extent.z), (220, 220, 216))
    builder.box((0, 0, low + 0.2), (0.4, 0.4, 0.4), DARK)
    for tilt in (0.6, -0.6):
        builder.limb((0.17, -0.45, 1.95 - tilt * 0.3), (0.17, 0.45, 1.95 + tilt * 0.3), 0.12, 0.03, WHITE)
    builder.cylinder((0, 0, low + 1.6), (0, 0, 2.2), 0.04, STEEL, sides=6)


def _carton(builder: Builder, box: Box, name: str) -> None:
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    builder.box(box.center, (2 * hx, 2 * hy, 2 * hz), CARTON)
    builder.plate((cx, cy, low + 2 * hz + 0.004), (0.14 * hx, 2 * hy), (0, 0, 1.0), (222, 200, 150))
    for side in (1.0, -1.0):
        builder.plate(
            (cx + side * (hx + 0.004), cy, low + 1.6 * hz), (0.16 * hy, 0.8 * hz), (side, 0, 0), (222, 200, 150)
        )
        builder.plate(
            (cx, cy + side * (hy + 0.004), low + 0.7 * hz), (0.5 * hx, 0.4 * hz), (0, side, 0), (240, 236, 226)
        )


def _paper_bag(builder: Builder, box: Box, name: str) -> None:
    """Brown paper with two handles, open and a little crumpled at the top."""
    del name
    (hx, hy, hz), low = box.extent, _low(box)
    top = low + 1.6 * hz
    base: list[Point] = [(hx * a * 0.9, hy * b * 0.94, low) for a, b in _RING]
    waist: list[Point] = [(hx * a, hy * b, low + 0.9 * hz) for a, b in _RING]
    rim: list[Point] = [(hx * a * 0.84 + 0.01 * b, hy * b * 0.97, top - 0.02 * (a * b > 0)) for a, b in _RING]
    builder.hull(base, waist, (190, 146, 92))
    builder.hull(waist, rim, (206, 164, 108), (84, 60, 38))
    for side in (0.8, -0.8):
        ends = [
            (side * hx, part * hy, z)
            for part, z in ((-0.45, top - 0.02), (-0.3, low + 1.97 * hz), (0.3, low + 1.97 * hz), (0.45, top - 0.02))
        ]
        for one, other in itertools.pairwise(ends):
            builder.limb(one, other, 0.018, 0.018, (150, 108, 62))
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


def _bag(builder: Builder, box: Box, name: str) -> None:
    color: Color = (30, 32, 34) if "trash" in name else ((236, 240, 244) if "plastic" in name else (190, 60, 70))
    (hx, hy, hz), low = box.extent, _low(box)
    levels = ((0.0, 0.75), (0.35, 1.0), (0.7, 0.7), (0.85, 0.2), (1.0, 0.42))
    for (a, r0), (b, r1) in itertools.pairwise(levels):
        one: list[Point] = [(hx * r0 * math.cos(t), hy * r0 * math.sin(t), low + 2 * hz * a) for t in _EIGHT]
        two: list[Point] = [
            (hx * r1 * math.cos(t + 0.1), hy * r1 * math.sin(t + 0.1), low + 2 * hz * b) for t in _EIGHT
        ]
        builder.hull(one, two, shade(color, 0.85 + 0.3 * a))


def _rock(builder: Builder, box: Box, name: str) -> None:
    random = Random(name)
    (hx, hy, hz), low = box.extent, _low(box)
    grey: Color = (128, 124, 118)
    levels = ((0.0, 0.86), (0.35, 1.0), (0.75, 0.74), (1.0, 0.30))
    rings: list[list[Point]] = []
    for rise, r in levels:
        spread = [random.uniform(0.82, 1.0) for _ in _EIGHT]
        rings.append(
            [
                (hx * r * k * math.cos(t), hy * r * k * math.sin(t), low + 2 * hz * rise)
                for t, k in zip(_EIGHT, spread, strict=True)
            ]
        )
    for number, (one, two) in enumerate(itertools.pairwise(rings)):
        builder.hull(one, two, shade(grey, 0.9 + 0.1 * number))


def _rubble(builder: Builder, box: Box, name: str) -> None:
    """Heaps of dirt and stones, flat on the road."""
    random = Random(name)
    (hx, hy, hz), low = box.extent, _low(box)
    for number in range(4):
        x, y = random.uniform(-0.45, 0.45) * hx, random.uniform(-0.45, 0.45) * hy
        r = random.uniform(0.4, 0.6)
        one: list[Point] = [(x + hx * r * math.cos(t), y + hy * r * math.sin(t), low) for t in _EIGHT]
        two: list[Point] = [
            (x + 0.4 * hx * r * math.cos(t), y + 0.4 * hy * r * math.sin(t), low + 2 * hz * random.uniform(0.5, 1.0))
            for t in _EIGHT
        ]
        builder.hull(one, two, shade((118, 92, 66), 0.85 + 0.1 * number))
    for _ in range(16):
        x, y, size = random.uniform(-0.95, 0.95) * hx, random.uniform(-0.95, 0.95) * hy, random.uniform(0.05, 0.13)
        builder.box(
            (x, y, low + size / 2),
            (size, size * 1.3, size),
            shade((140, 132, 122), random.uniform(0.7, 1.1)),
            random.uniform(0, 90),
        )


def _container(builder: Builder, box: Box, name: str) -> None:
    color: Color = {"glass": (46, 120, 70), "cloth": (220, 150, 40)}.get(name[:5], (38, 84, 132))
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    builder.box((cx, cy, low + hz * 0.94), (2 * hx, 2 * hy, 1.88 * hz), color)
    builder.box((cx, cy, low + 1.94 * hz), (2 * hx, 2 * hy, 0.12 * hz), shade(color, 0.7))
    for number in range(7):
        at = 2 * (number + 0.5) / 7 - 1
        for side in (1.0, -1.0):
            builder.plate(
                (cx + at * hx, cy + side * (hy + 0.006), low + hz), (0.06, 1.6 * hz), (0, side, 0), shade(color, 0.75)
            )
            builder.plate(
                (cx + side * (hx + 0.006), cy + at * hy, low + hz), (0.06, 1.6 * hz), (side, 0, 0), shade(color, 0.75)
            )


def _warning(builder: Builder, box: Box, name: str) -> None:
    """A red triangle on feet, for an accident or for roadworks; both faces show it."""
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    for side in (0.72, -0.72):
        foot = (cx, cy + side * hy, low + 0.03)
        builder.box(foot, (2 * hx, 0.07, 0.06), DARK)
        builder.limb((cx, cy + side * hy, low), (cx, cy + side * hy, low + 0.75 * hz), 0.05, 0.05, DARK)
    middle, radius = low + 1.25 * hz, min(hy * 1.1, 0.75 * hz)
    for side in (1.0, -1.0):
        for offset, part, color in (
            (0.03, 1.0, RED),
            (0.042, 0.7, (255, 214, 40) if "construction" in name else WHITE),
        ):
            ring = [
                (
                    cx + side * offset,
                    cy + part * radius * math.cos(a),
                    middle - 0.05 * radius + part * radius * math.sin(a),
                )
                for a in (math.pi / 2, math.pi * 7 / 6, math.pi * 11 / 6)
            ]
            builder.face(ring, color, (side, 0, 0))
        lettering(
            builder,
            "!",
            (cx + side * 0.055, cy, middle - 0.08 * radius),
            (0, -side, 0),
            UP,
            0.62 * radius,
            (20, 20, 20),
        )


def _arrow_board(builder: Builder, box: Box, name: str) -> None:
    """A trailer with a lit arrow, as roadworks have."""
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    builder.box((cx, cy, low + 0.65), (1.5 * hx, 1.1 * hy, 0.35), AMBER)
    for side in (1.0, -1.0):
        builder.cylinder(
            (cx, cy + side * 0.62 * hy, low + 0.35),
            (cx, cy + side * 0.78 * hy, low + 0.35),
            0.35,
            (26, 26, 28),
            sides=12,
            cap=(120, 122, 126),
        )
        builder.box((cx, cy + side * 0.4 * hy, low + 1.2), (0.1, 0.1, 1.2), STEEL)
    middle = low + 1.42 * hz
    builder.box((cx, cy, middle), (0.16, 2 * hy, 1.16 * hz), (24, 24, 26))
    for side in (1.0, -1.0):
        x = cx + side * 0.09
        spots = [(y / 4, 0.0) for y in range(-4, 4)] + [
            (0.55, 0.38),
            (0.75, 0.19),
            (0.95, 0.0),
            (0.75, -0.19),
            (0.55, -0.38),
        ]
        for y, z in spots:
            builder.disc(
                (x, cy + y * 0.8 * hy, middle + z * hz), 0.10, (side, 0, 0), (255, 186, 20), sides=8, glow=True
            )
        for z in (-0.5, 0.5):
            _stripe_row(builder, (x + 0.004 * side, cy, middle + z * hz), hy, side)


def _stripe_row(builder: Builder, middle: Point, half: float, side: float) -> None:
    for number in range(10):
        y = middle[1] + (2 * (number + 0.5) / 10 - 1) * half
        builder.plate((middle[0], y, middle[2]), (half / 5, 0.14), (side, 0, 0), RED if number % 2 else WHITE)


def _barrel(builder: Builder, box: Box, name: str) -> None:
    color: Color = ORANGE if name == "barrel" else ((70, 76, 80) if "trashcan" in name else (46, 90, 60))
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    r = min(hx, hy)
    for a, b, k in ((0.0, 0.35, 1.0), (0.35, 0.55, 1.0), (0.55, 0.9, 1.0), (0.9, 1.0, 0.9)):
        shown = WHITE if (a, name) == (0.35, "barrel") else shade(color, k)
        builder.cylinder(
            (cx, cy, low + 2 * hz * a), (cx, cy, low + 2 * hz * b), r, shown, sides=10, cap=shade(color, 0.6)
        )


def _bench(builder: Builder, box: Box, name: str) -> None:
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    seat = min(0.46, 2 * hz)
    for number in range(4):
        builder.box((cx, cy + (number - 1.5) * hy * 0.45, low + seat), (2 * hx, hy * 0.36, 0.05), WOOD)
    for end in (0.8, -0.8):
        builder.box((cx + end * hx, cy, low + seat / 2), (0.08, 1.5 * hy, seat), DARK)
    if name == "bench01":
        for number in range(3):
            builder.box((cx, cy - 0.9 * hy, low + seat + 0.16 + 0.16 * number), (2 * hx, 0.05, 0.11), WOOD)


def _table(builder: Builder, box: Box, name: str) -> None:
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    top = 2 * hz if name != "plastictable" else 0.75
    builder.box((cx, cy, low + top), (1.7 * hx, 1.7 * hy, 0.06), WOOD if name == "table" else WHITE)
    for a, b in _RING:
        builder.box((cx + a * 0.7 * hx, cy + b * 0.7 * hy, low + top / 2), (0.06, 0.06, top), STEEL)
    if name == "plastictable":
        builder.cylinder((cx, cy, low + top), (cx, cy, low + 2 * hz - 0.1), 0.03, STEEL, sides=6)
        builder.cylinder((cx, cy, low + 1.7 * hz), (cx, cy, low + 2 * hz), hx, (210, 60, 50), sides=8, tip=0.05)


def _pot(builder: Builder, box: Box, name: str) -> None:
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    builder.box((cx, cy, low + 0.55 * hz), (2 * hx, 2 * hy, 1.1 * hz), (150, 92, 66))
    for part in (-0.55, 0.0, 0.55):
        at = (cx + part * hx, cy) if hx > hy else (cx, cy + part * hy)
        builder.cylinder(
            (at[0], at[1], low + 1.0 * hz),
            (at[0], at[1], low + 2 * hz),
            0.6 * min(hx, hy),
            (74, 124, 60),
            sides=6,
            tip=0.3 * min(hx, hy),
        )


def _shelter(builder: Builder, box: Box, name: str) -> None:
    """A bus stop: glass back, roof and bench."""
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    builder.box((cx, cy, low + 2 * hz - 0.08), (2 * hx, 2 * hy, 0.16), (60, 92, 128))
    for a, b in _RING:
        builder.box((cx + a * 0.94 * hx, cy + b * 0.94 * hy, low + hz), (0.08, 0.08, 2 * hz), DARK)
    back = (2 * hx * 0.9, 0.03, 1.5 * hz) if hx > hy else (0.03, 2 * hy * 0.9, 1.5 * hz)
    at = (cx, cy - 0.9 * hy) if hx > hy else (cx - 0.9 * hx, cy)
    builder.box((at[0], at[1], low + hz), back, (160, 190, 204))
    seat = (1.4 * hx, 0.35, 0.06) if hx > hy else (0.35, 1.4 * hy, 0.06)
    builder.box((at[0] * 0.6 + cx * 0.4, at[1] * 0.6 + cy * 0.4, low + 0.5), seat, WOOD)


def _machine(builder: Builder, box: Box, name: str) -> None:
    """Vending machines, cash machines, kiosks, stalls, advertisements: a box with a bright front on each long side."""
    color: Color = {"vend": (206, 34, 40), "atm": (40, 90, 150), "adve": (60, 64, 70), "mail": (230, 190, 40)}.get(
        name[:4], (128, 92, 60)
    )
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    builder.box(box.center, (2 * hx, 2 * hy, 2 * hz), color)
    bright: Color = (120, 196, 226) if name.startswith("adv") else (210, 226, 232)
    for side in (1.0, -1.0):
        if hx >= hy:
            builder.plate((cx, cy + side * (hy + 0.01), low + 1.2 * hz), (1.6 * hx, 1.2 * hz), (0, side, 0), bright)
        else:
            builder.plate((cx + side * (hx + 0.01), cy, low + 1.2 * hz), (1.6 * hy, 1.2 * hz), (side, 0, 0), bright)


def _stall(builder: Builder, box: Box, name: str) -> None:
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    builder.box((cx, cy, low + 0.5 * hz), (1.7 * hx, 1.7 * hy, 0.8 * hz), (236, 226, 206))
    for number in range(8):
        y = cy + (2 * (number + 0.5) / 8 - 1) * hy
        builder.box((cx, y, low + 1.7 * hz), (2 * hx, hy / 4, 0.12 * hz), RED if number % 2 else WHITE)
    for a, b in _RING:
        builder.box((cx + 0.9 * a * hx, cy + 0.9 * b * hy, low + 0.85 * hz), (0.06, 0.06, 1.7 * hz), STEEL)
    builder.box((cx, cy, low + 1.9 * hz), (0.5 * hx, hy, 0.2 * hz), AMBER)


def _sign(builder: Builder, box: Box, name: str) -> None:
    (hx, hy, hz), low = box.extent, _low(box)
    wide = name == "streetsign01"
    for x in (-0.7 * hx, 0.7 * hx) if wide else (0.0,):
        builder.cylinder((x, 0, low), (x, 0, low + 2 * hz), 0.04, STEEL, sides=6)
    for side in (1.0, -1.0):
        builder.plate(
            (0.0, side * 0.06, low + 1.65 * hz),
            (2 * hx, 0.6 * hz),
            (0, side, 0),
            (20, 110, 70) if wide else (30, 84, 170),
        )
        lettering(
            builder, "EXIT" if wide else "P", (0.0, side * 0.075, low + 1.65 * hz), (-side, 0, 0), UP, 0.34 * hz, WHITE
        )
    del hy


def _ball(builder: Builder, box: Box, name: str) -> None:
    del name
    r, (cx, cy, cz) = box.extent.z, box.center
    levels = ((-1.0, 0.3), (-0.5, 0.87), (0.0, 1.0), (0.5, 0.87), (1.0, 0.3))
    for number, ((a, r0), (b, r1)) in enumerate(itertools.pairwise(levels)):
        builder.cylinder(
            (cx, cy, cz + a * r), (cx, cy, cz + b * r), r0 * r, (WHITE, RED)[number % 2], sides=8, tip=r1 * r
        )


def _tyre(builder: Builder, box: Box, name: str) -> None:
    del name
    low = _low(box)
    builder.cylinder((0, 0, low), (0, 0, low + 2 * box.extent.z), box.extent.x, (28, 28, 30), sides=14)
    builder.cylinder(
        (0, 0, low + 2 * box.extent.z),
        (0, 0, low + 2 * box.extent.z + 0.004),
        0.55 * box.extent.x,
        (74, 70, 64),
        sides=10,
    )


def _paper(builder: Builder, box: Box, name: str) -> None:
    (hx, hy, hz), low = box.extent, _low(box)
    color: Color = (240, 238, 230) if name == "paper" else CARTON
    random = Random(name)
    ring: list[Point] = [(hx * a, hy * b, low + 2 * hz * random.uniform(0.3, 1.0) + 0.012) for a, b in _RING]
    builder.face([ring[0], ring[1], ring[2]], color, UP)
    builder.face([ring[0], ring[2], ring[3]], shade(color, 0.92), UP)
    builder.face([ring[0], ring[1], ring[2]], color, (0, 0, -1.0))


def _bale(builder: Builder, box: Box, name: str) -> None:
    del name
    (hx, hy, hz), (cx, cy, cz) = box.extent, box.center
    builder.cylinder((cx, cy - hy, cz), (cx, cy + hy, cz), min(hx, hz), (212, 178, 92), sides=14, cap=(186, 150, 74))


def _loose_door(builder: Builder, box: Box, name: str) -> None:
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    builder.box((cx, cy, low + 0.6 * hz), (2 * hx, 2 * hy, 1.2 * hz), (120, 124, 130))
    builder.box((cx - 0.1 * hx, cy, low + 1.6 * hz), (1.6 * hx, hy, 0.8 * hz), (60, 74, 86))
    del name


def _chain(builder: Builder, box: Box, name: str) -> None:
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, _low(box), box.center
    ends = (-0.9, 0.9) if max(hx, hy) > 0.3 else (0.0,)
    for end in ends:
        builder.cylinder((cx + end * hx, cy, low), (cx + end * hx, cy, low + 2 * hz), 0.07, RED, sides=8)
    if len(ends) == 2:
        builder.limb((cx - 0.9 * hx, cy, low + 1.6 * hz), (cx, cy, low + 1.2 * hz), 0.05, 0.05, WHITE)
        builder.limb((cx, cy, low + 1.2 * hz), (cx + 0.9 * hx, cy, low + 1.6 * hz), 0.05, 0.05, WHITE)


def _plain(builder: Builder, box: Box, name: str) -> None:
    """A box in a colour of its own."""
    color = Random(name).choice(((150, 120, 90), (110, 120, 132), (134, 104, 110), (120, 134, 104), (160, 150, 130)))
    (hx, hy, hz), (cx, cy, cz) = box.extent, box.center
    low: list[Point] = [(cx + a * hx, cy + b * hy, cz - hz) for a, b in _RING]
    high: list[Point] = [(cx + a * hx * 0.96, cy + b * hy * 0.96, cz + hz) for a, b in _RING]
    builder.hull(low, high, color, shade(color, 1.15))


_RING = ((1, 1), (1, -1), (-1, -1), (-1, 1))
_EIGHT = [2 * math.pi * (one + 0.5) / 8 for one in range(8)]
Form = Callable[[Builder, Box, str], None]
FORMS: tuple[tuple[tuple[str, ...], Form], ...] = (
    (("crossinggatepost",), _gate_post),
    (("crossinggate",), _gate),
    (("cone",), _cone),
    (("streetbarrier",), _barrier),
    (("chainbarrier",), _chain),
    (("warningaccident", "warningconstruction"), _warning),
    (("trafficwarning",), _arrow_board),
    (("paperbag",), _paper_bag),
    (("trashbag", "plasticbag", "shoppingbag", "purse"), _bag),
    (("platformgarbage", "dirtdebris"), _rubble),
    (("creasedbox02", "creasedbox01"), _carton),
    (("paper", "creasedbox", "garbage", "ironplank"), _paper),
    (("rock",), _rock),
    (("box", "travelcase", "briefcase"), _carton),
    (("container",), _container),
    (("barrel", "trashcan", "bin"), _barrel),
    (("bench",), _bench),
    (("table",), _table),
    (("plantpot",), _pot),
    (("busstop",), _shelter),
    (("foodcart",), _stall),
    (("vendingmachine", "atm", "kiosk", "advertisement", "mailbox", "oil_station"), _machine),
    (("streetsign",), _sign),
    (("ball", "toy", "helmet"), _ball),
    (("tyre",), _tyre),
    (("haybale",), _bale),
    (("cardoor",), _loose_door),
)
"""The first whose word is part of a prop's name makes it."""
