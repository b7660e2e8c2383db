"""Props that close roads: cones, barriers, warnings, gates."""

from __future__ import annotations

import math

from carlette.camera.models.lettering import lettering
from carlette.camera.models.mesh import Builder, Color, Point, shade
from carlette.camera.models.palette import AMBER, DARK, ORANGE, STEEL, low_of
from carlette.camera.models.signs import RED, UP, WHITE
from carlette.geometry import Box


def cone(builder: Builder, box: Box, name: str) -> None:
    """Build a striped cone on its foot."""
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
    radius = min(hx, hy)
    builder.box((cx, cy, low + 0.03), (2 * hx, 2 * hy, 0.06), (40, 40, 42) if name == "trafficcone01" else ORANGE)
    height = 2 * hz - 0.06
    cuts = ((0.0, 0.30, ORANGE), (0.30, 0.50, WHITE), (0.50, 0.68, ORANGE), (0.68, 0.84, WHITE), (0.84, 1.0, ORANGE))
    for a, b, color in cuts:
        r = (0.72 * radius * (1 - 0.86 * a), 0.72 * radius * (1 - 0.86 * b))
        builder.cylinder(
            (cx, cy, low + 0.06 + a * height), (cx, cy, low + 0.06 + b * height), r[0], color, sides=10, tip=r[1]
        )


def barrier(builder: Builder, box: Box, name: str) -> None:
    """Build two striped boards on feet; the wide side is the longer one."""
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
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


def gate(builder: Builder, box: Box, name: str) -> None:
    """Build the striped bar of a level crossing, with its lamps."""
    del name
    _striped(builder, box.center, box.extent.y, box.extent.z, True, 2 * box.extent.x)
    for part in (-0.6, 0.0, 0.6, 0.96):
        builder.box(
            (box.center.x, box.center.y + part * box.extent.y, box.center.z - 0.12),
            (0.1, 0.1, 0.12),
            (255, 30, 20),
            glow=True,
        )


def gate_post(builder: Builder, box: Box, name: str) -> None:
    """Build the post of a level crossing, with its cross."""
    del name
    low = low_of(box)
    builder.box((0, 0, low + box.extent.z), (0.3, 0.3, 2 * box.extent.z), (220, 220, 216))
    builder.box((0, 0, low + 0.2), (0.4, 0.4, 0.4), DARK)
    for tilt in (0.6, -0.6):
        builder.limb((0.17, -0.45, 1.95 - tilt * 0.3), (0.17, 0.45, 1.95 + tilt * 0.3), 0.12, 0.03, WHITE)
    builder.cylinder((0, 0, low + 1.6), (0, 0, 2.2), 0.04, STEEL, sides=6)


def warning(builder: Builder, box: Box, name: str) -> None:
    """Build a red triangle on feet, for an accident or for roadworks; both faces show it."""
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
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


def arrow_board(builder: Builder, box: Box, name: str) -> None:
    """Build a trailer with a lit arrow, as at roadworks."""
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
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


def barrel(builder: Builder, box: Box, name: str) -> None:
    """Build barrels and bins; the orange barrel has a white band."""
    color: Color = ORANGE if name == "barrel" else ((70, 76, 80) if "trashcan" in name else (46, 90, 60))
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
    r = min(hx, hy)
    for a, b, k in ((0.0, 0.35, 1.0), (0.35, 0.55, 1.0), (0.55, 0.9, 1.0), (0.9, 1.0, 0.9)):
        shown = WHITE if (a, name) == (0.35, "barrel") else shade(color, k)
        builder.cylinder(
            (cx, cy, low + 2 * hz * a), (cx, cy, low + 2 * hz * b), r, shown, sides=10, cap=shade(color, 0.6)
        )


def chain(builder: Builder, box: Box, name: str) -> None:
    """Build red posts with a chain between them."""
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
    ends = (-0.9, 0.9) if max(hx, hy) > 0.3 else (0.0,)
    for end in ends:
        builder.cylinder((cx + end * hx, cy, low), (cx + end * hx, cy, low + 2 * hz), 0.07, RED, sides=8)
    if len(ends) == 2:
        builder.limb((cx - 0.9 * hx, cy, low + 1.6 * hz), (cx, cy, low + 1.2 * hz), 0.05, 0.05, WHITE)
        builder.limb((cx, cy, low + 1.2 * hz), (cx + 0.9 * hx, cy, low + 1.6 * hz), 0.05, 0.05, WHITE)
