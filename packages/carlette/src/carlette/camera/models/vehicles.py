"""Cars, vans, trucks and buses as meshes that fit their bounding boxes."""

from __future__ import annotations

from carlette.camera.models.livery import dress_car
from carlette.camera.models.mesh import Builder, Color, Mesh, Point, mix, shade
from carlette.camera.models.trucks_and_buses import build_bus, build_truck
from carlette.camera.models.vehicle_body import (
    BUMPER,
    GLASS,
    SEAM,
    SEDAN,
    STYLES,
    VAN,
    BodyDimensions,
    Style,
    body_kind,
    frame_of,
    wheels,
)
from carlette.geometry import Box


def vehicle_mesh(type_id: str, box: Box, wheelbase_m: float, color: Color) -> Mesh:
    """Return a four-wheeled vehicle without its lamps."""
    builder = Builder()
    frame = frame_of(type_id, box)
    kind = body_kind(type_id)
    if kind == "truck":
        build_truck(builder, type_id, frame, wheelbase_m, color)
    elif kind == "bus":
        build_bus(builder, type_id, frame, wheelbase_m, color)
    else:
        _car(builder, type_id, frame, wheelbase_m, color)
    return builder.mesh()


def _car(builder: Builder, type_id: str, frame: BodyDimensions, wheelbase_m: float, color: Color) -> None:
    style = STYLES.get(type_id, SEDAN)
    paint = _paint(type_id, color)
    height, hl = frame.high - frame.low, frame.length / 2
    stations = [
        (frame.middle + x * hl, frame.low + low * height, frame.low + high * height, b * frame.half, a * frame.half)
        for x, low, high, b, a in style.body
    ]
    builder.loft(stations, paint, frame.y)
    _cabin(builder, style, frame, paint)
    _bumpers(builder, frame)
    if style is not VAN:
        _seams(builder, frame, style, height)
    wheels(builder, frame, wheelbase_m, style.wheel, frame.half)
    for side in (1.0, -1.0):
        at = frame.middle + (style.cabin[1] - 0.10) * hl
        builder.box(
            (at, frame.y + side * (frame.half + 0.01), frame.low + 0.68 * height), (0.13, 0.13, 0.13), shade(paint, 0.7)
        )
    dress_car(builder, type_id, frame)


def _cabin(builder: Builder, style: Style, frame: BodyDimensions, paint: Color) -> None:
    hl, height = frame.length / 2, frame.high - frame.low
    rear, front, roof_rear, roof_front = (frame.middle + x * hl for x in style.cabin)
    belt, top = frame.low + style.belt * height, frame.high - 0.05
    below, above = frame.half * 0.94, frame.half * style.roof_half
    low: list[Point] = [
        (front, frame.y + below, belt),
        (front, frame.y - below, belt),
        (rear, frame.y - below, belt),
        (rear, frame.y + below, belt),
    ]
    high: list[Point] = [
        (roof_front, frame.y + above, top),
        (roof_front, frame.y - above, top),
        (roof_rear, frame.y - above, top),
        (roof_rear, frame.y + above, top),
    ]
    if style is VAN:
        builder.hull(low, high, paint)
        _van_glass(builder, frame, (belt, top), (front, roof_front), (below, above))
    else:
        builder.hull(low, high, GLASS, shade(paint, 0.96))
    slab = [(x, y, top + 0.05) for x, y, _ in high]
    builder.hull(
        high, [(frame.middle + (x - frame.middle) * 0.96, frame.y + (y - frame.y) * 0.92, z) for x, y, z in slab], paint
    )
    for side in (1.0, -1.0):
        for u in style.pillars:
            quad = []
            for part, v in ((u, 0.0), (u + 0.06, 0.0), (u + 0.06, 1.0), (u, 1.0)):
                x = (rear + (front - rear) * part) * (1 - v) + (roof_rear + (roof_front - roof_rear) * part) * v
                quad.append((x, frame.y + side * (below * (1 - v) + above * v + 0.012), belt * (1 - v) + top * v))
            builder.face(quad, paint, (0.0, side, 0.2))


def _van_glass(
    builder: Builder,
    frame: BodyDimensions,
    levels: tuple[float, float],
    fronts: tuple[float, float],
    halves: tuple[float, float],
) -> None:
    (belt, top), (front, roof), (below, above) = levels, fronts, halves
    screen = []
    for w, v in ((0.92, 0.04), (-0.92, 0.04), (-0.92, 0.72), (0.92, 0.72)):
        y = frame.y + w * (below * (1 - v) + above * v)
        screen.append((front - (front - roof) * v + 0.012, y, belt + (top - belt) * v + 0.01))
    builder.face(screen, GLASS, (1.0, 0.0, 0.3))
    for side in (1.0, -1.0):
        half = (below + above) / 2 + 0.03
        low, high = belt + 0.06, belt + 0.62 * (top - belt)
        corners = ((roof - 0.85, low), (front - 0.16, low), (roof - 0.02, high), (roof - 0.85, high))
        window = [(x, frame.y + side * half, z) for x, z in corners]
        builder.face(window, GLASS, (0.0, side, 0.0))
    for side in (1.0, -1.0):
        builder.plate(
            (frame.rear - 0.012, frame.y + side * 0.45 * frame.half, (belt + top) / 2 + 0.06),
            (frame.half * 0.72, 0.5 * (top - belt)),
            (-1.0, 0.0, 0.0),
            GLASS,
        )
    builder.plate(
        (frame.rear - 0.014, frame.y, (frame.low + top) / 2), (0.03, 0.8 * (top - frame.low)), (-1.0, 0, 0), SEAM
    )


def _bumpers(builder: Builder, frame: BodyDimensions) -> None:
    z = frame.low + 0.36
    for x, side in ((frame.rear - 0.005, -1.0), (frame.front + 0.005, 1.0)):
        builder.box((x - 0.06 * side, frame.y, z), (0.14, 1.72 * frame.half, 0.16), BUMPER)
        builder.plate((x + 0.02 * side, frame.y, z + 0.06), (0.52, 0.12), (side, 0.0, 0.0), (236, 236, 226))


def _seams(builder: Builder, frame: BodyDimensions, style: Style, height: float) -> None:
    """Build door gaps and handles, and a grille between the headlamps."""
    hl = frame.length / 2
    low, high = frame.low + 0.2 * height, frame.low + (style.belt + 0.01) * height
    rear, front = style.cabin[0], style.cabin[1]
    places = [front - 0.10, (rear + front) / 2 - 0.02]
    if len(style.pillars) > 2:
        places.append(rear + 0.30)
    for side in (1.0, -1.0):
        y = frame.y + side * (frame.half + 0.012)
        for x in places:
            at = frame.middle + x * hl
            builder.plate((at, y, (low + high) / 2), (0.025, high - low), (0.0, side, 0.0), SEAM)
            builder.plate((at - 0.28 * 1.0, y, high - 0.14), (0.16, 0.035), (0.0, side, 0.0), SEAM)
    builder.plate(
        (frame.front + 0.015, frame.y, frame.lamp_z - 0.02), (frame.half * 0.9, 0.13), (1.0, 0, 0), (24, 26, 28)
    )


def _paint(type_id: str, color: Color) -> Color:
    if type_id == "vehicle.tesla.cybertruck":
        return mix(color, (176, 180, 184), 0.7)
    if type_id == "vehicle.ford.crown":
        return (244, 196, 34)
    return color
