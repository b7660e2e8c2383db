"""Cars, vans, trucks and buses as meshes, made to measure of their bounding boxes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from carlette.camera.font import lettering
from carlette.camera.mesh import Builder, Color, Mesh, Point, mix, shade
from carlette.geometry import Box

GLASS: Color = (44, 56, 68)
TYRE: Color = (30, 30, 32)
RIM: Color = (168, 172, 176)
BUMPER: Color = (46, 48, 52)
SEAM: Color = (28, 30, 32)
FIRE_RED: Color = (196, 26, 24)
SCHOOL_YELLOW: Color = (248, 172, 16)
UP: Point = (0.0, 0.0, 1.0)
ROOF_GEAR_M = (("police", 0.21), ("ambulance", 0.21), ("ford.crown", 0.17))
"""Height of what stands on the roof: light bars and taxi signs belong to the measured box."""


@dataclass(frozen=True)
class Style:
    """Proportions of a car: x in half lengths, z in heights, y in half widths of the body."""

    body: tuple[tuple[float, float, float, float, float], ...]
    """Stations from the rear: x, lower and upper z, half widths below and above."""
    cabin: tuple[float, float, float, float]
    """x of the glasshouse at the belt (rear, front) and at the roof (rear, front)."""
    belt: float = 0.62
    roof_half: float = 0.74
    wheel: float = 0.335
    """Radius in metres."""
    pillars: tuple[float, ...] = (0.0, 0.47, 0.94)


SEDAN = Style(
    (
        (-1.0, 0.24, 0.52, 0.84, 0.78), (-0.96, 0.15, 0.645, 0.95, 0.88), (-0.6, 0.13, 0.665, 1.0, 0.94),
        (0.34, 0.13, 0.645, 1.0, 0.94), (0.88, 0.14, 0.53, 0.97, 0.88), (1.0, 0.22, 0.44, 0.82, 0.78),
    ),
    (-0.74, 0.46, -0.44, 0.10),
)  # fmt: skip
HATCH = Style(
    (
        (-1.0, 0.20, 0.58, 0.88, 0.84), (-0.94, 0.14, 0.64, 0.97, 0.92), (0.36, 0.13, 0.63, 1.0, 0.94),
        (0.88, 0.14, 0.54, 0.97, 0.88), (1.0, 0.22, 0.44, 0.84, 0.80),
    ),
    (-0.97, 0.52, -0.80, 0.12),
)  # fmt: skip
COUPE = replace(SEDAN, cabin=(-0.86, 0.36, -0.46, 0.02), roof_half=0.68, pillars=(0.0, 0.90))
SUV = Style(
    (
        (-1.0, 0.22, 0.60, 0.90, 0.88), (-0.95, 0.17, 0.62, 0.98, 0.94), (0.44, 0.16, 0.62, 1.0, 0.95),
        (0.90, 0.17, 0.56, 0.98, 0.92), (1.0, 0.22, 0.50, 0.88, 0.86),
    ),
    (-0.97, 0.54, -0.88, 0.20), 0.60, 0.82, 0.38, (0.0, 0.34, 0.64, 0.95),
)  # fmt: skip
JEEP = replace(SUV, cabin=(-0.96, 0.34, -0.94, 0.24), roof_half=0.90, wheel=0.40)
WEDGE = Style(
    (
        (-1.0, 0.26, 0.62, 0.96, 0.92), (-0.95, 0.20, 0.64, 1.0, 0.94), (0.42, 0.20, 0.60, 1.0, 0.94),
        (0.96, 0.22, 0.52, 0.98, 0.92), (1.0, 0.28, 0.48, 0.92, 0.90),
    ),
    (-0.98, 0.62, 0.02, 0.06), 0.61, 0.70, 0.44, (0.0, 0.52, 0.94),
)  # fmt: skip
VAN = Style(
    (
        (-1.0, 0.12, 0.50, 0.96, 0.96), (0.50, 0.11, 0.50, 1.0, 0.98), (0.88, 0.12, 0.44, 0.98, 0.92),
        (1.0, 0.16, 0.34, 0.88, 0.84),
    ),
    (-1.0, 0.70, -0.98, 0.44), 0.50, 0.90, 0.36, (),
)  # fmt: skip
BUBBLE = replace(HATCH, cabin=(-0.9, 0.9, -0.5, 0.35), pillars=(0.0, 0.45, 0.93), wheel=0.26, belt=0.55)

STYLES: dict[str, Style] = {
    "vehicle.audi.a2": HATCH, "vehicle.citroen.c3": HATCH, "vehicle.nissan.micra": HATCH, "vehicle.seat.leon": HATCH,
    "vehicle.mini.cooper_s": HATCH, "vehicle.mini.cooper_s_2021": HATCH, "vehicle.toyota.prius": HATCH,
    "vehicle.audi.tt": COUPE, "vehicle.ford.mustang": COUPE, "vehicle.mercedes.coupe": COUPE,
    "vehicle.bmw.grandtourer": SUV, "vehicle.audi.etron": SUV, "vehicle.nissan.patrol": SUV,
    "vehicle.nissan.patrol_2021": SUV, "vehicle.jeep.wrangler_rubicon": JEEP, "vehicle.tesla.cybertruck": WEDGE,
    "vehicle.micro.microlino": BUBBLE, "vehicle.mercedes.sprinter": VAN, "vehicle.ford.ambulance": VAN,
    "vehicle.volkswagen.t2": VAN, "vehicle.volkswagen.t2_2021": VAN,
}  # fmt: skip


@dataclass(frozen=True)
class Frame:
    """Measures that body, lamps and doors share, in the actor's frame."""

    rear: float
    front: float
    half: float
    """Half width of the body, without mirrors."""
    y: float
    low: float
    high: float
    lamp_z: float
    tail_z: float
    lamp_half: float

    @property
    def length(self) -> float:
        return self.front - self.rear

    @property
    def middle(self) -> float:
        return (self.front + self.rear) / 2


def frame_of(type_id: str, box: Box) -> Frame:
    """The measures of a vehicle's body in its box."""
    (cx, cy, cz), (hx, hy, hz) = box.center, box.extent
    low = max(cz - hz, 0.0)
    height = cz + hz - low
    heavy = body_kind(type_id)
    half = hy - (0.08 if hy < 0.95 else 0.12)
    high = low + height - next((drop for word, drop in ROOF_GEAR_M if word in type_id), 0.02)
    lamp, tail = {"car": (0.46, 0.52), "truck": (0.24, 0.26), "bus": (0.24, 0.26)}[heavy]
    if STYLES.get(type_id) is VAN:
        lamp, tail = 0.33, 0.34
    return Frame(
        cx - hx + 0.08, cx + hx - 0.08, half, cy, low, high, low + lamp * height, low + tail * height, half * 0.82
    )  # fmt: skip


def body_kind(type_id: str) -> str:
    """`car` (with vans), `truck` or `bus`: which way a vehicle is built."""
    if type_id in ("vehicle.mitsubishi.fusorosa", "vehicle.carlette.schoolbus"):
        return "bus"
    if type_id in (
        "vehicle.carlamotors.carlacola",
        "vehicle.carlamotors.european_hgv",
        "vehicle.carlamotors.firetruck",
    ):
        return "truck"
    return "car"


def vehicle_mesh(type_id: str, box: Box, wheelbase_m: float, color: Color) -> Mesh:
    """A four-wheeled vehicle without its lamps."""
    builder = Builder()
    frame = frame_of(type_id, box)
    kind = body_kind(type_id)
    if kind == "truck":
        _truck(builder, type_id, frame, wheelbase_m, color)
    elif kind == "bus":
        _bus(builder, type_id, frame, wheelbase_m, color)
    else:
        _car(builder, type_id, frame, wheelbase_m, color)
    return builder.mesh()


def _car(builder: Builder, type_id: str, frame: Frame, wheelbase_m: float, color: Color) -> None:
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
    _wheels(builder, frame, wheelbase_m, style.wheel, frame.half)
    for side in (1.0, -1.0):
        at = frame.middle + (style.cabin[1] - 0.10) * hl
        builder.box(
            (at, frame.y + side * (frame.half + 0.01), frame.low + 0.68 * height), (0.13, 0.13, 0.13), shade(paint, 0.7)
        )
    _dress(builder, type_id, frame, style)


def _cabin(builder: Builder, style: Style, frame: Frame, paint: Color) -> None:
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
    frame: Frame,
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


def _bumpers(builder: Builder, frame: Frame) -> None:
    z = frame.low + 0.36
    for x, side in ((frame.rear - 0.005, -1.0), (frame.front + 0.005, 1.0)):
        builder.box((x - 0.06 * side, frame.y, z), (0.14, 1.72 * frame.half, 0.16), BUMPER)
        builder.plate((x + 0.02 * side, frame.y, z + 0.06), (0.52, 0.12), (side, 0.0, 0.0), (236, 236, 226))


def _seams(builder: Builder, frame: Frame, style: Style, height: float) -> None:
    """Door gaps and handles, and a grille between the headlamps."""
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


def _wheels(
    builder: Builder, frame: Frame, wheelbase_m: float, radius: float, half: float, axles: Sequence[float] | None = None
) -> None:
    at = axles or (frame.middle + wheelbase_m / 2, frame.middle - wheelbase_m / 2)
    for x in at:
        for side in (1.0, -1.0):
            face = frame.y + side * (half + 0.02)
            builder.disc((x, face, frame.low + radius + 0.06), radius * 1.12, (0.0, side, 0.0), (20, 20, 22), sides=14)
            inner = frame.y + side * (half - 0.20)
            outer = frame.y + side * (half + 0.035)
            builder.cylinder((x, inner, radius), (x, outer, radius), radius, TYRE, sides=12)
            builder.disc((x, outer + side * 0.004, radius), radius * 0.62, (0.0, side, 0.0), RIM, sides=10)
            builder.disc((x, outer + side * 0.008, radius), radius * 0.22, (0.0, side, 0.0), (90, 92, 96), sides=6)


def _paint(type_id: str, color: Color) -> Color:
    if type_id == "vehicle.tesla.cybertruck":
        return mix(color, (176, 180, 184), 0.7)
    if type_id == "vehicle.ford.crown":
        return (244, 196, 34)
    return color


def _dress(builder: Builder, type_id: str, frame: Frame, style: Style) -> None:
    """What marks police, ambulance and taxi; the spare wheel of a jeep."""
    height, hl = frame.high - frame.low, frame.length / 2
    if "police" in type_id:
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
    elif "ambulance" in type_id:
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
    elif type_id == "vehicle.ford.crown":
        builder.box((frame.middle - 0.18 * hl, frame.y, frame.high + 0.07), (0.18, 0.7, 0.18), (250, 250, 240))
        for side, right in ((1.0, (0.0, -1.0, 0.0)), (-1.0, (0.0, 1.0, 0.0))):
            place = (frame.middle - 0.18 * hl + side * 0.1, frame.y, frame.high + 0.07)
            lettering(builder, "TAXI", place, right, UP, 0.13, (20, 20, 20), width_m=0.5)
    elif style is JEEP:
        builder.cylinder((frame.rear + 0.05, frame.y, 0.95), (frame.rear - 0.08, frame.y, 0.95), 0.34, TYRE, sides=12)


def _cross(builder: Builder, middle: Point, side: float) -> None:
    for size in ((0.42, 0.14), (0.14, 0.42)):
        builder.plate(middle, size, (0.0, side, 0.0), (24, 80, 180))


def _truck(builder: Builder, type_id: str, frame: Frame, wheelbase_m: float, color: Color) -> None:
    fire, cola = "firetruck" in type_id, "carlacola" in type_id
    paint = FIRE_RED if fire else ((206, 30, 36) if cola else color)
    height, top = frame.high - frame.low, frame.high
    cab = frame.front - min(2.1, 0.36 * frame.length)
    cab_top = frame.low + (0.92 if cola else 0.80) * height
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
    _truck_dress(builder, fire, cola, frame, (rear, cab, top))
    axles = (frame.front - 1.15, frame.front - 1.15 - wheelbase_m)
    _wheels(builder, frame, wheelbase_m, 0.50, frame.half, axles)


def _truck_dress(builder: Builder, fire: bool, cola: bool, frame: Frame, place: tuple[float, float, float]) -> None:
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


def _bus(builder: Builder, type_id: str, frame: Frame, wheelbase_m: float, color: Color) -> None:
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
        face = frame.front - nose
    else:
        builder.loft(
            (
                (frame.front - nose, low, top - 0.1, frame.half, frame.half * 0.95),
                (frame.front, low, top - 0.45, frame.half, frame.half * 0.93),
            ),
            paint,
            frame.y,
        )
        face = frame.front
    screen_low = 1.7 if school else 1.25
    builder.plate(
        (face + 0.03, frame.y, (screen_low + top - 0.65) / 2),
        (1.78 * frame.half, top - 0.65 - screen_low),
        (1.0, 0, 0),
        GLASS,
    )
    count = max(4, int((frame.length - nose - 1.2) / 1.15))
    for side in (1.0, -1.0):
        y = frame.y + side * (frame.half + 0.012)
        for number in range(count):
            x = frame.rear + 0.5 + (number + 0.5) * (frame.length - nose - 1.0) / count
            builder.plate((x, y, belt + 0.62), (0.92, 0.85), (0, side, 0), GLASS)
        if school:
            for z in (1.0, 1.35):
                builder.plate((frame.middle - nose / 2, y, z), (frame.length - nose - 0.2, 0.09), (0, side, 0), SEAM)
    builder.plate(
        (frame.middle + 0.33 * frame.length, frame.y + frame.half + 0.02, 1.35),
        (0.85, 1.75),
        (0, 1.0, 0),
        shade(GLASS, 0.8),
    )
    builder.plate((frame.rear - 0.012, frame.y, belt + 0.65), (1.3 * frame.half, 0.8), (-1.0, 0, 0), GLASS)
    if school:
        _school_words(builder, frame, face, top)
    else:
        builder.plate((face + 0.035, frame.y, top - 0.48), (1.2, 0.26), (1.0, 0, 0), (20, 20, 22))
        lettering(
            builder, "BUS 12", (face + 0.05, frame.y, top - 0.48), (0, -1.0, 0), UP, 0.2, (250, 180, 40), width_m=0.9
        )
    builder.box((frame.rear - 0.02, frame.y, 0.5), (0.14, 1.9 * frame.half, 0.2), BUMPER)
    builder.box((frame.front + 0.02, frame.y, 0.5), (0.14, 1.8 * frame.half, 0.2), BUMPER)
    axles = (frame.middle + wheelbase_m * 0.5 + (0.2 if school else 0), frame.middle - wheelbase_m * 0.5)
    _wheels(builder, frame, wheelbase_m, 0.50, frame.half, axles)


def _school_words(builder: Builder, frame: Frame, face: float, top: float) -> None:
    for x, right, side in ((face + 0.04, (0.0, -1.0, 0.0), 1.0), (frame.rear - 0.03, (0.0, 1.0, 0.0), -1.0)):
        lettering(builder, "SCHOOL BUS", (x, frame.y, top - 0.36), right, UP, 0.26, (16, 16, 16), width_m=1.5)
        for aside in (0.82, -0.82):
            builder.plate((x - 0.02 * side, frame.y + aside * frame.half, top - 0.34), (0.34, 0.3), (side, 0, 0), SEAM)
