"""Trucks and buses."""

from __future__ import annotations

from carlette.camera.models.lettering import lettering
from carlette.camera.models.livery import dress_school_bus, dress_truck
from carlette.camera.models.mesh import Builder, Color, shade
from carlette.camera.models.vehicle_body import BUMPER, FIRE_RED, GLASS, SCHOOL_YELLOW, SEAM, UP, BodyDimensions, wheels


def build_truck(builder: Builder, type_id: str, frame: BodyDimensions, wheelbase_m: float, color: Color) -> None:
    """Build a cab and a load: fire engine, drinks truck or a plain box."""
    fire, cola = "firetruck" in type_id, "carlacola" in type_id
    paint = FIRE_RED if fire else ((206, 30, 36) if cola else color)
    height, top = frame.high - frame.low, frame.high
    cab = frame.front - min(2.1, 0.36 * frame.length)
    cab_top = frame.low + (0.92 if cola else 0.80) * height
    _cab(builder, frame, paint, (cab, cab_top))
    load = FIRE_RED if fire else ((196, 24, 30) if cola else (226, 228, 230))
    rear = frame.rear + 0.05
    builder.loft(
        (
            (rear, 0.75, top - 0.1 * fire * height, frame.half, frame.half),
            (cab - 0.12, 0.75, top - 0.1 * fire * height, frame.half, frame.half),
        ),
        load,
        frame.y,
    )
    builder.box(((rear + cab) / 2, frame.y, 0.62), (cab - rear, 1.5 * frame.half, 0.3), BUMPER)
    builder.box((rear, frame.y, 0.5), (0.12, 1.9 * frame.half, 0.16), BUMPER)
    builder.plate((rear - 0.01, frame.y, (0.75 + top) / 2), (0.04, top - 0.9), (-1.0, 0, 0), shade(load, 0.6))
    if not fire and not cola:
        builder.plate((rear - 0.012, frame.y, 0.82), (1.9 * frame.half, 0.12), (-1.0, 0, 0), (230, 60, 30))
    dress_truck(builder, fire, cola, frame, (rear, cab, top))
    axles = (frame.front - 1.15, frame.front - 1.15 - wheelbase_m)
    wheels(builder, frame, wheelbase_m, 0.50, frame.half, axles)


def build_bus(builder: Builder, type_id: str, frame: BodyDimensions, wheelbase_m: float, color: Color) -> None:
    """Build a city bus, or a school bus with its nose."""
    school = "schoolbus" in type_id
    paint = SCHOOL_YELLOW if school else color
    low, top = 0.42, frame.high
    nose = 1.5 if school else 0.25
    belt = frame.low + 0.50 * (frame.high - frame.low)
    builder.loft(
        (
            (frame.rear, low, top - 0.15, frame.half, frame.half * 0.95),
            (frame.rear + 0.2, low, top, frame.half, frame.half * 0.95),
            (frame.front - nose - 0.2, low, top, frame.half, frame.half * 0.95),
            (frame.front - nose, low, belt if not school else top - 0.25, frame.half, frame.half * 0.95),
        ),
        paint,
        frame.y,
    )
    face = _nose(builder, frame, paint, nose, school=school)
    screen_low = 1.7 if school else 1.25
    builder.plate(
        (face + 0.03, frame.y, (screen_low + top - 0.65) / 2),
        (1.78 * frame.half, top - 0.65 - screen_low),
        (1.0, 0, 0),
        GLASS,
    )
    _windows(builder, frame, nose, belt, school=school)
    builder.plate(
        (frame.middle + 0.33 * frame.length, frame.y + frame.half + 0.02, 1.35),
        (0.85, 1.75),
        (0, 1.0, 0),
        shade(GLASS, 0.8),
    )
    builder.plate((frame.rear - 0.012, frame.y, belt + 0.65), (1.3 * frame.half, 0.8), (-1.0, 0, 0), GLASS)
    if school:
        dress_school_bus(builder, frame, face, top)
    else:
        builder.plate((face + 0.035, frame.y, top - 0.48), (1.2, 0.26), (1.0, 0, 0), (20, 20, 22))
        lettering(
            builder, "BUS 12", (face + 0.05, frame.y, top - 0.48), (0, -1.0, 0), UP, 0.2, (250, 180, 40), width_m=0.9
        )
    builder.box((frame.rear - 0.02, frame.y, 0.5), (0.14, 1.9 * frame.half, 0.2), BUMPER)
    builder.box((frame.front + 0.02, frame.y, 0.5), (0.14, 1.8 * frame.half, 0.2), BUMPER)
    axles = (frame.middle + wheelbase_m * 0.5 + (0.2 if school else 0), frame.middle - wheelbase_m * 0.5)
    wheels(builder, frame, wheelbase_m, 0.50, frame.half, axles)


def _cab(builder: Builder, frame: BodyDimensions, paint: Color, place: tuple[float, float]) -> None:
    """Build the cab of a truck from x to the front; `place` is that x and its top."""
    cab, cab_top = place
    height = frame.high - frame.low
    builder.loft(
        (
            (cab, 0.45, cab_top, frame.half, frame.half * 0.94),
            (frame.front - 0.12, 0.42, cab_top - 0.08, frame.half, frame.half * 0.94),
            (frame.front, 0.4, 0.52 * height, frame.half * 0.96, frame.half * 0.94),
        ),
        paint,
        frame.y,
    )
    builder.plate(
        (frame.front + 0.012, frame.y, frame.low + 0.40 * height),
        (1.6 * frame.half, 0.10 * height),
        (1.0, 0, 0),
        (30, 32, 36),
    )
    screen = [
        (
            frame.front + 0.01 - 0.12 * v,
            frame.y + w * frame.half * 0.9,
            0.52 * height + (cab_top - 0.1 - 0.52 * height) * v,
        )
        for w, v in ((1, 0.02), (-1, 0.02), (-1, 0.82), (1, 0.82))
    ]
    builder.face(screen, GLASS, (1.0, 0.0, 0.2))
    for side in (1.0, -1.0):
        builder.plate(
            ((cab + frame.front) / 2 + 0.1, frame.y + side * (frame.half + 0.01), 0.63 * height),
            (0.5 * (frame.front - cab), 0.22 * height),
            (0, side, 0),
            GLASS,
        )
        builder.box(
            (frame.front - 0.2, frame.y + side * (frame.half + 0.01), 0.62 * height), (0.12, 0.13, 0.5), (30, 30, 32)
        )


def _nose(builder: Builder, frame: BodyDimensions, paint: Color, nose: float, *, school: bool) -> float:
    """Build the front of a bus. Returns x of its windshield."""
    low, top = 0.42, frame.high
    if school:
        builder.loft(
            (
                (frame.front - nose, low, 1.62, frame.half * 0.95, frame.half * 0.9),
                (frame.front - 0.1, low, 1.42, frame.half * 0.9, frame.half * 0.8),
                (frame.front, 0.5, 1.2, frame.half * 0.85, frame.half * 0.75),
            ),
            paint,
            frame.y,
        )
        return frame.front - nose
    builder.loft(
        (
            (frame.front - nose, low, top - 0.1, frame.half, frame.half * 0.95),
            (frame.front, low, top - 0.45, frame.half, frame.half * 0.93),
        ),
        paint,
        frame.y,
    )
    return frame.front


def _windows(builder: Builder, frame: BodyDimensions, nose: float, belt: float, *, school: bool) -> None:
    count = max(4, int((frame.length - nose - 1.2) / 1.15))
    for side in (1.0, -1.0):
        y = frame.y + side * (frame.half + 0.012)
        for number in range(count):
            x = frame.rear + 0.5 + (number + 0.5) * (frame.length - nose - 1.0) / count
            builder.plate((x, y, belt + 0.62), (0.92, 0.85), (0, side, 0), GLASS)
        if school:
            for z in (1.0, 1.35):
                builder.plate((frame.middle - nose / 2, y, z), (frame.length - nose - 0.2, 0.09), (0, side, 0), SEAM)
