"""Props of streets: benches, containers, stalls, machines."""

from __future__ import annotations

from random import Random

from carlette.camera.models.lettering import lettering
from carlette.camera.models.mesh import Builder, Color, Point, shade
from carlette.camera.models.palette import AMBER, DARK, RING, STEEL, WOOD, low_of
from carlette.camera.models.signs import RED, UP, WHITE
from carlette.geometry import Box


def container(builder: Builder, box: Box, name: str) -> None:
    """Build containers with ribs and a lid."""
    color: Color = {"glass": (46, 120, 70), "cloth": (220, 150, 40)}.get(name[:5], (38, 84, 132))
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
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


def bench(builder: Builder, box: Box, name: str) -> None:
    """Build slats on feet."""
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
    seat = min(0.46, 2 * hz)
    for number in range(4):
        builder.box((cx, cy + (number - 1.5) * hy * 0.45, low + seat), (2 * hx, hy * 0.36, 0.05), WOOD)
    for end in (0.8, -0.8):
        builder.box((cx + end * hx, cy, low + seat / 2), (0.08, 1.5 * hy, seat), DARK)
    if name == "bench01":
        for number in range(3):
            builder.box((cx, cy - 0.9 * hy, low + seat + 0.16 + 0.16 * number), (2 * hx, 0.05, 0.11), WOOD)


def table(builder: Builder, box: Box, name: str) -> None:
    """Build a table; the plastic one has a parasol."""
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
    top = 2 * hz if name != "plastictable" else 0.75
    builder.box((cx, cy, low + top), (1.7 * hx, 1.7 * hy, 0.06), WOOD if name == "table" else WHITE)
    for a, b in RING:
        builder.box((cx + a * 0.7 * hx, cy + b * 0.7 * hy, low + top / 2), (0.06, 0.06, top), STEEL)
    if name == "plastictable":
        builder.cylinder((cx, cy, low + top), (cx, cy, low + 2 * hz - 0.1), 0.03, STEEL, sides=6)
        builder.cylinder((cx, cy, low + 1.7 * hz), (cx, cy, low + 2 * hz), hx, (210, 60, 50), sides=8, tip=0.05)


def pot(builder: Builder, box: Box, name: str) -> None:
    """Build a plant pot with its plants."""
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
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


def shelter(builder: Builder, box: Box, name: str) -> None:
    """Build a bus stop: glass back, roof and bench."""
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
    builder.box((cx, cy, low + 2 * hz - 0.08), (2 * hx, 2 * hy, 0.16), (60, 92, 128))
    for a, b in RING:
        builder.box((cx + a * 0.94 * hx, cy + b * 0.94 * hy, low + hz), (0.08, 0.08, 2 * hz), DARK)
    back = (2 * hx * 0.9, 0.03, 1.5 * hz) if hx > hy else (0.03, 2 * hy * 0.9, 1.5 * hz)
    at = (cx, cy - 0.9 * hy) if hx > hy else (cx - 0.9 * hx, cy)
    builder.box((at[0], at[1], low + hz), back, (160, 190, 204))
    seat = (1.4 * hx, 0.35, 0.06) if hx > hy else (0.35, 1.4 * hy, 0.06)
    builder.box((at[0] * 0.6 + cx * 0.4, at[1] * 0.6 + cy * 0.4, low + 0.5), seat, WOOD)


def machine(builder: Builder, box: Box, name: str) -> None:
    """Build a box with a bright front on each long side.

    It represents vending machines, cash machines, kiosks, stalls and advertisements.
    """
    color: Color = {"vend": (206, 34, 40), "atm": (40, 90, 150), "adve": (60, 64, 70), "mail": (230, 190, 40)}.get(
        name[:4], (128, 92, 60)
    )
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
    builder.box(box.center, (2 * hx, 2 * hy, 2 * hz), color)
    bright: Color = (120, 196, 226) if name.startswith("adv") else (210, 226, 232)
    for side in (1.0, -1.0):
        if hx >= hy:
            builder.plate((cx, cy + side * (hy + 0.01), low + 1.2 * hz), (1.6 * hx, 1.2 * hz), (0, side, 0), bright)
        else:
            builder.plate((cx + side * (hx + 0.01), cy, low + 1.2 * hz), (1.6 * hy, 1.2 * hz), (side, 0, 0), bright)


def stall(builder: Builder, box: Box, name: str) -> None:
    """Build a stall under a striped roof."""
    del name
    (hx, hy, hz), low, (cx, cy, _) = box.extent, low_of(box), box.center
    builder.box((cx, cy, low + 0.5 * hz), (1.7 * hx, 1.7 * hy, 0.8 * hz), (236, 226, 206))
    for number in range(8):
        y = cy + (2 * (number + 0.5) / 8 - 1) * hy
        builder.box((cx, y, low + 1.7 * hz), (2 * hx, hy / 4, 0.12 * hz), RED if number % 2 else WHITE)
    for a, b in RING:
        builder.box((cx + 0.9 * a * hx, cy + 0.9 * b * hy, low + 0.85 * hz), (0.06, 0.06, 1.7 * hz), STEEL)
    builder.box((cx, cy, low + 1.9 * hz), (0.5 * hx, hy, 0.2 * hz), AMBER)


def sign(builder: Builder, box: Box, name: str) -> None:
    """Build a street sign with two readable sides."""
    (hx, hy, hz), low = box.extent, low_of(box)
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


def plain(builder: Builder, box: Box, name: str) -> None:
    """Build a box in its own color."""
    color = Random(name).choice(((150, 120, 90), (110, 120, 132), (134, 104, 110), (120, 134, 104), (160, 150, 130)))
    (hx, hy, hz), (cx, cy, cz) = box.extent, box.center
    low: list[Point] = [(cx + a * hx, cy + b * hy, cz - hz) for a, b in RING]
    high: list[Point] = [(cx + a * hx * 0.96, cy + b * hy * 0.96, cz + hz) for a, b in RING]
    builder.hull(low, high, color, shade(color, 1.15))
