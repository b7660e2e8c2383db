"""Common parts of all four-wheeled vehicles: proportions by kind, dimensions from their box, wheels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from carlette.camera.models.mesh import Builder, Color, Point
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
"""Height of roof equipment (m): light bars and taxi signs are part of the measured box."""


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
    """Radius (m)."""
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
class BodyDimensions:
    """Dimensions shared by body, lamps and doors, in the actor's frame (m)."""

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
        """Length of the body (m)."""
        return self.front - self.rear

    @property
    def middle(self) -> float:
        """Middle of the body along x (m)."""
        return (self.front + self.rear) / 2


def frame_of(type_id: str, box: Box) -> BodyDimensions:
    """Return the measures of a vehicle's body in its box."""
    (cx, cy, cz), (hx, hy, hz) = box.center, box.extent
    low = max(cz - hz, 0.0)
    height = cz + hz - low
    heavy = body_kind(type_id)
    half = hy - (0.08 if hy < 0.95 else 0.12)
    high = low + height - next((drop for word, drop in ROOF_GEAR_M if word in type_id), 0.02)
    lamp, tail = {"car": (0.375, 0.52), "truck": (0.24, 0.26), "bus": (0.24, 0.26)}[heavy]
    if STYLES.get(type_id) is VAN:
        lamp, tail = 0.33, 0.34
    return BodyDimensions(
        cx - hx + 0.08, cx + hx - 0.08, half, cy, low, high, low + lamp * height, low + tail * height, half * 0.82
    )  # fmt: skip


def body_kind(type_id: str) -> str:
    """Return the kind of a vehicle's body: `car` (also vans), `truck` or `bus`."""
    if type_id in ("vehicle.mitsubishi.fusorosa", "vehicle.carlette.schoolbus"):
        return "bus"
    if type_id in (
        "vehicle.carlamotors.carlacola",
        "vehicle.carlamotors.european_hgv",
        "vehicle.carlamotors.firetruck",
    ):
        return "truck"
    return "car"


def wheels(
    builder: Builder,
    frame: BodyDimensions,
    wheelbase_m: float,
    radius: float,
    half: float,
    axles: Sequence[float] | None = None,
) -> None:
    """Build wheels in dark arches; at `axles` (x), or a wheelbase apart."""
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
