"""Lettering and paint on vehicles: police, ambulance, taxi, fire engine, school bus."""

from __future__ import annotations

from carlette.camera.models.lettering import lettering
from carlette.camera.models.mesh import Builder, Point
from carlette.camera.models.vehicle_body import SEAM, TYRE, UP, BodyDimensions


def dress_car(builder: Builder, type_id: str, frame: BodyDimensions) -> None:
    """Build the markings of police, ambulance and taxi; the spare wheel of a jeep."""
    if "police" in type_id:
        _police(builder, frame)
    elif "ambulance" in type_id:
        _ambulance(builder, frame)
    elif type_id == "vehicle.ford.crown":
        _taxi(builder, frame)
    elif "jeep" in type_id:
        builder.cylinder((frame.rear + 0.05, frame.y, 0.95), (frame.rear - 0.08, frame.y, 0.95), 0.34, TYRE, sides=12)


def dress_truck(
    builder: Builder, fire: bool, cola: bool, frame: BodyDimensions, place: tuple[float, float, float]
) -> None:
    """Build stripes, ladders and words of a truck; `place` is x of its rear and of its cab, and its top."""
    rear, cab, top = place
    middle, span = (rear + cab) / 2, cab - rear
    for side in (1.0, -1.0):
        y = frame.y + side * (frame.half + 0.015)
        if fire:
            builder.plate((frame.middle, y, 1.05), (frame.length * 0.94, 0.26), (0, side, 0), (244, 240, 232))
            builder.plate(
                (frame.middle, y + side * 0.006, 1.05), (frame.length * 0.94, 0.09), (0, side, 0), (246, 210, 30)
            )
            for number in range(3):
                builder.plate(
                    (rear + span * (number + 0.5) / 3, y, 1.75), (span / 3.5, 0.9), (0, side, 0), (150, 154, 158)
                )
            lettering(
                builder,
                "FIRE",
                (cab + 0.85, y + side * 0.01, 1.45),
                (-side, 0, 0),
                UP,
                0.34,
                (250, 240, 220),
                width_m=1.1,
            )
        elif cola:
            lettering(builder, "COLA", (middle, y, top - 0.75), (-side, 0, 0), UP, 0.8, (250, 250, 250), width_m=2.2)
            builder.plate((middle, y, 1.0), (span * 0.96, 0.14), (0, side, 0), (250, 250, 250))
        else:
            builder.plate((middle, y, 1.15), (span * 0.96, 0.10), (0, side, 0), (230, 60, 30))
            lettering(builder, "CARGO", (middle, y, top - 0.9), (-side, 0, 0), UP, 0.6, (40, 60, 110), width_m=2.4)
    if fire:
        for side in (0.35, -0.35):
            builder.box((middle, frame.y + side, top - 0.24), (span, 0.07, 0.09), (206, 208, 210))
        for number in range(9):
            builder.box((rear + span * (number + 0.5) / 9, frame.y, top - 0.24), (0.05, 0.7, 0.05), (206, 208, 210))
        lettering(builder, "FIRE", (rear - 0.02, frame.y, 2.2), (0, 1.0, 0), UP, 0.4, (250, 240, 220), width_m=1.2)
        for number in range(6):
            paint = (250, 214, 30) if number % 2 else (196, 26, 24)
            builder.plate(
                (rear - 0.012, frame.y + (number - 2.5) * frame.half / 3.2, 1.2),
                (frame.half / 3.3, 0.6),
                (-1.0, 0, 0),
                paint,
            )


def dress_school_bus(builder: Builder, frame: BodyDimensions, face: float, top: float) -> None:
    """Build the name over both ends, next to the warning lamps."""
    for x, right, side in ((face + 0.04, (0.0, -1.0, 0.0), 1.0), (frame.rear - 0.03, (0.0, 1.0, 0.0), -1.0)):
        lettering(builder, "SCHOOL BUS", (x, frame.y, top - 0.36), right, UP, 0.26, (16, 16, 16), width_m=1.5)
        for aside in (0.82, -0.82):
            builder.plate((x - 0.02 * side, frame.y + aside * frame.half, top - 0.34), (0.34, 0.3), (side, 0, 0), SEAM)


def _police(builder: Builder, frame: BodyDimensions) -> None:
    height, hl = frame.high - frame.low, frame.length / 2
    for side in (1.0, -1.0):
        y = frame.y + side * (frame.half + 0.016)
        builder.plate(
            (frame.middle - 0.05 * hl, y, frame.low + 0.42 * height),
            (0.92 * hl, 0.34 * height),
            (0.0, side, 0.0),
            (18, 22, 40),
        )
        middle = (frame.middle - 0.05 * hl, y + side * 0.01, frame.low + 0.44 * height)
        lettering(builder, "POLICE", middle, (-side, 0.0, 0.0), UP, 0.26, (250, 250, 250), width_m=1.5)
    lettering(
        builder,
        "POLICE",
        (frame.rear - 0.02, frame.y, frame.low + 0.60 * height),
        (0.0, 1.0, 0.0),
        UP,
        0.13,
        (18, 22, 60),
        width_m=0.8,
    )


def _ambulance(builder: Builder, frame: BodyDimensions) -> None:
    height, hl = frame.high - frame.low, frame.length / 2
    for side in (1.0, -1.0):
        y = frame.y + side * (frame.half + 0.02)
        builder.plate(
            (frame.middle - 0.2 * hl, y, frame.low + 0.36 * height),
            (1.5 * hl, 0.10 * height),
            (0.0, side, 0.0),
            (220, 40, 24),
        )
        builder.plate(
            (frame.middle - 0.2 * hl, y, frame.low + 0.28 * height),
            (1.5 * hl, 0.05 * height),
            (0.0, side, 0.0),
            (246, 196, 20),
        )
        lettering(
            builder,
            "AMBULANCE",
            (frame.middle - 0.42 * hl, y - side * 0.01, frame.low + 0.74 * height),
            (-side, 0, 0),
            UP,
            0.34,
            (210, 24, 24),
            width_m=2.3,
        )
        _cross(builder, (frame.middle - 0.42 * hl, y, frame.low + 0.54 * height), side)
    lettering(
        builder,
        "AMBULANCE",
        (frame.rear - 0.03, frame.y, frame.low + 0.44 * height),
        (0.0, 1.0, 0.0),
        UP,
        0.2,
        (210, 24, 24),
        width_m=1.5,
    )
    builder.plate(
        (frame.rear - 0.02, frame.y, frame.low + 0.30 * height),
        (1.7 * frame.half, 0.14),
        (-1.0, 0, 0),
        (246, 196, 20),
    )
    builder.plate((frame.front + 0.03, frame.y, frame.low + 0.36 * height), (1.0, 0.14), (1.0, 0, 0), (210, 24, 24))


def _taxi(builder: Builder, frame: BodyDimensions) -> None:
    hl = frame.length / 2
    builder.box((frame.middle - 0.18 * hl, frame.y, frame.high + 0.07), (0.18, 0.7, 0.18), (250, 250, 240))
    for side, right in ((1.0, (0.0, -1.0, 0.0)), (-1.0, (0.0, 1.0, 0.0))):
        place = (frame.middle - 0.18 * hl + side * 0.1, frame.y, frame.high + 0.07)
        lettering(builder, "TAXI", place, right, UP, 0.13, (20, 20, 20), width_m=0.5)


def _cross(builder: Builder, middle: Point, side: float) -> None:
    for size in ((0.42, 0.14), (0.14, 0.42)):
        builder.plate(middle, size, (0.0, side, 0.0), (24, 80, 180))
