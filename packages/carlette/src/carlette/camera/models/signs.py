"""Traffic signs with their faces, on posts. A sign is at the origin and its face looks along +x."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from carlette.camera.models.lettering import lettering
from carlette.camera.models.mesh import Builder, Color, Mesh, Point
from carlette.camera.rendering import tags

RED: Color = (200, 24, 30)
WHITE: Color = (244, 244, 240)
BLACK: Color = (20, 20, 20)
BLUE: Color = (24, 84, 176)
AMBER: Color = (252, 196, 22)
STEEL: Color = (142, 146, 150)
BACK: Color = (120, 122, 126)
ROAD_CLOSED, DETOUR = "250", "454"
"""German numbers of signs: closed to all vehicles, and detour. They have words on them as in the Americas."""
POST_TOP_M = 2.6
"""Height of a post's top (m). Ours."""
FACE_M = 2.25
"""Height of a face's center (m). Ours."""
RIGHT: Point = (0.0, 1.0, 0.0)
"""To the right of a reader of the face, along -x; CARLA's y points to the right of +x."""
READERS_RIGHT: Point = (0.0, -1.0, 0.0)
UP: Point = (0.0, 0.0, 1.0)
FRONT: Point = (1.0, 0.0, 0.0)


def post_sign(kind: str, value: str = "") -> Mesh:
    """Return a whole sign by its OpenDRIVE type (CARLA's maps use the German numbers) and value."""
    builder = Builder(tags.POLE)
    builder.cylinder((0, 0, 0), (0, 0, POST_TOP_M), 0.04, STEEL, sides=6)
    builder.tag = tags.TRAFFIC_SIGN
    face_of(builder, kind, value, (0.06, 0.0, FACE_M))
    return builder.mesh()


def face_of(builder: Builder, kind: str, value: str, middle: Point) -> None:
    """Add a sign's plate."""
    if kind == "206":
        stop_face(builder, middle)
    elif kind == "205":
        _ring(builder, middle, _corners(3, 0.52, -90.0), RED, WHITE, 0.62)
        _write(builder, (middle[0], middle[1], middle[2] + 0.08), "YIELD", 0.1, RED, 0.36)
    elif kind == "274":
        _round(builder, middle, RED, WHITE)
        _write(builder, middle, value or "50", 0.34, BLACK)
    elif kind in ("101", "warning", "150", "151"):
        _ring(builder, middle, _corners(3, 0.52, 90.0), RED, WHITE, 0.72)
        _write(builder, (middle[0], middle[1], middle[2] - 0.03), "!", 0.36, BLACK)
    elif kind == "267":
        _round(builder, middle, RED, RED)
        _plate(builder, (middle[0] + 0.02, middle[1], middle[2]), 0.5, 0.12, WHITE)
    elif kind == ROAD_CLOSED:
        _lines(builder, middle, ("ROAD", "CLOSED"), WHITE, BLACK)
    elif kind == DETOUR:
        _lines(builder, middle, ("DETOUR",), AMBER, BLACK)
    elif kind == "306":
        _ring(builder, middle, _corners(4, 0.44, 0.0), WHITE, AMBER, 0.72)
    elif kind == "201":
        for tilt in (35.0, -35.0):
            _plate(builder, middle, 1.1, 0.18, WHITE, tilt)
    elif kind == "350":
        _plate(builder, middle, 0.6, 0.6, BLUE)
        _ring(builder, (middle[0] + 0.02, middle[1], middle[2]), _corners(3, 0.26, 90.0), WHITE, WHITE, 0.5)
    else:
        _plate(builder, middle, 0.6, 0.6, BLUE)
        _plate(builder, (middle[0] + 0.02, middle[1], middle[2]), 0.12, 0.4, WHITE)


def kind_of(name: str, type_: str, value: str) -> tuple[str, str] | None:
    """Return the type and value of a sign from its entry in the map; None if it is not a sign."""
    limit = re.search(r"speed[a-z_]*?(\d+)", name.lower())
    if limit:
        return "274", limit.group(1)
    if "stop" in name.lower() and "stencil" not in name.lower() and "line" not in name.lower():
        return "206", ""
    if "yield" in name.lower():
        return "205", ""
    if re.search(r"road_?closed", name.lower()):
        return ROAD_CLOSED, ""
    if "detour" in name.lower():
        return DETOUR, ""
    if type_.isdigit() and type_ != "1000001":
        number = value.split(".")[0]
        return type_, number if number.lstrip("-").isdigit() and not number.startswith("-") else ""
    return None


def stop_face(builder: Builder, middle: Point, radius_m: float = 0.48) -> None:
    """Build the red octagon."""
    _ring(builder, middle, _corners(8, radius_m, 22.5), WHITE, RED, 0.92)
    _write(builder, middle, "STOP", radius_m * 0.62, WHITE, radius_m * 1.44)


def _round(builder: Builder, middle: Point, rim: Color, inside: Color) -> None:
    _ring(builder, middle, _corners(16, 0.42, 0.0), rim, inside, 0.78)


def _corners(count: int, radius: float, first_deg: float) -> list[tuple[float, float]]:
    turns = (math.radians(first_deg + 360.0 * item / count) for item in range(count))
    return [(radius * math.cos(turn), radius * math.sin(turn)) for turn in turns]


def _ring(
    builder: Builder, middle: Point, shape: Sequence[tuple[float, float]], rim: Color, inside: Color, share: float
) -> None:
    """Build a plate of that shape with a rim; gray on its back."""
    for offset, part, color in ((0.0, 1.0, rim), (0.012, share, inside)):
        points = [(middle[0] + offset, middle[1] + y * part, middle[2] + z * part) for y, z in shape]
        builder.face(points, color, FRONT)
    builder.face([(middle[0] - 0.01, middle[1] + y, middle[2] + z) for y, z in shape], BACK, (-1.0, 0.0, 0.0))


def _plate(builder: Builder, middle: Point, width: float, height: float, color: Color, tilt_deg: float = 0.0) -> None:
    cos, sin = math.cos(math.radians(tilt_deg)), math.sin(math.radians(tilt_deg))
    ring = [(width / 2 * a, height / 2 * b) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    shape = [(y * cos - z * sin, y * sin + z * cos) for y, z in ring]
    _ring(builder, middle, shape, color, color, 0.5)


def _lines(builder: Builder, middle: Point, lines: Sequence[str], ground: Color, ink: Color) -> None:
    """Build a plate as wide as its longest line, with the lines one below the other."""
    _plate(builder, middle, 0.2 * max(map(len, lines)) + 0.16, 0.36 * len(lines) + 0.12, ground)
    for number, line in enumerate(lines):
        up_m = 0.36 * ((len(lines) - 1) / 2.0 - number)
        _write(builder, (middle[0], middle[1], middle[2] + up_m), line, 0.26, ink)


def _write(builder: Builder, middle: Point, text: str, height: float, color: Color, width: float | None = None) -> None:
    place = (middle[0] + 0.03, middle[1], middle[2])
    lettering(builder, text, place, READERS_RIGHT, UP, height, color, width_m=width)
