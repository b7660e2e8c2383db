"""Bicycles and motorcycles with their riders."""

from __future__ import annotations

import math

from carlette.camera.models.mesh import Builder, Color, Mesh, Point
from carlette.camera.models.people import TOPS, Clothes, clothes_of, person
from carlette.camera.rendering import tags
from carlette.geometry import Box

RUBBER: Color = (26, 26, 28)
STEEL: Color = (150, 154, 158)


def cycle_mesh(type_id: str, box: Box, wheelbase_m: float, color: Color, pedal: float, *, motor: bool) -> Mesh:
    """Return a two-wheeler and its rider; `pedal` is the turn of the cranks (0 to 1)."""
    builder = Builder(0)
    middle, half = box.center.x, box.extent.x
    low = max(box.center.z - box.extent.z, 0.0)
    top = low + 2 * box.extent.z
    radius = _wheel_radius(type_id, motor)
    reach = min(wheelbase_m / 2, half - radius)
    for x in (middle + reach, middle - reach):
        _wheel(builder, (x, box.center.y, radius), radius, 0.045 if not motor else 0.13)
    if motor:
        seat = _motor_body(builder, type_id, box, (reach, radius), color)
    else:
        seat = _bicycle_frame(builder, box, (reach, radius), color, pedal)
    builder.tag = tags.RIDER
    _rider(builder, type_id, box, (seat, reach, top), pedal, motor=motor)
    return builder.mesh()


def lamp_places(type_id: str, box: Box, wheelbase_m: float) -> tuple[Point, Point]:
    """Return middles of a motorcycle's headlamp and of its tail lamp."""
    reach = min(wheelbase_m / 2, box.extent.x - _wheel_radius(type_id, motor=True))
    x, y = box.center.x, box.center.y
    return (x + reach + 0.03, y, 0.9), (x - reach - 0.25, y, 0.76)


def _wheel_radius(type_id: str, motor: bool) -> float:
    return 0.34 if not motor else (0.24 if "vespa" in type_id else 0.31)


def _wheel(builder: Builder, center: Point, radius: float, width: float) -> None:
    (x, y, z), sides = center, 12
    turns = [2 * math.pi * item / sides for item in range(sides)]
    for a, b in zip(turns, [*turns[1:], turns[0]], strict=True):
        for side in (1.0, -1.0):
            ring = [
                (x + r * math.cos(t), y + side * width / 2, z + r * math.sin(t))
                for r, t in ((radius, a), (radius, b), (radius * 0.84, b), (radius * 0.84, a))
            ]
            builder.face(ring, RUBBER, (0.0, side, 0.0))
        tread = [
            (x + radius * math.cos(t), y + w, z + radius * math.sin(t))
            for t, w in ((a, width / 2), (b, width / 2), (b, -width / 2), (a, -width / 2))
        ]
        builder.face(tread, RUBBER, (math.cos(a), 0.0, math.sin(a)))
    for turn in turns[::2]:
        tip = (x + radius * 0.85 * math.cos(turn), y, z + radius * 0.85 * math.sin(turn))
        builder.limb(center, tip, 0.012, 0.012, STEEL)


def _bicycle_frame(builder: Builder, box: Box, wheels: tuple[float, float], color: Color, pedal: float) -> Point:
    (reach, radius), x, y = wheels, box.center.x, box.center.y
    hub, front = (x - reach, y, radius), (x + reach, y, radius)
    crank, saddle, head = (x - 0.08, y, 0.30), (x - 0.26, y, 0.88), (x + reach - 0.16, y, 0.86)
    for a, b in ((hub, crank), (crank, saddle), (hub, saddle), (crank, head), (saddle, head), (head, front)):
        builder.limb(a, b, 0.045, 0.045, color)
    builder.box((saddle[0], y, saddle[2] + 0.05), (0.26, 0.14, 0.07), RUBBER)
    builder.limb(head, (head[0] + 0.04, y, 1.05), 0.04, 0.04, color)
    builder.box((head[0] + 0.04, y, 1.05), (0.05, 0.56, 0.04), RUBBER)
    builder.box((hub[0] - 0.02, y, 0.74), (0.05, 0.07, 0.07), (220, 20, 20), glow=True)
    for side in (1.0, -1.0):
        turn = 2 * math.pi * pedal + (0.0 if side > 0 else math.pi)
        foot = (crank[0] + 0.17 * math.cos(turn), y + 0.1 * side, crank[2] + 0.17 * math.sin(turn))
        builder.box(foot, (0.1, 0.09, 0.03), RUBBER)
    return (saddle[0], y, saddle[2] + 0.08)


def _motor_body(builder: Builder, type_id: str, box: Box, wheels: tuple[float, float], color: Color) -> Point:
    (reach, radius), x, y = wheels, box.center.x, box.center.y
    scooter, cruiser = "vespa" in type_id, "harley" in type_id
    seat_z = 0.74 if cruiser else 0.80
    if scooter:
        builder.loft(
            (
                (x - reach - 0.2, 0.32, 0.66, 0.14, 0.1),
                (x - reach + 0.1, 0.25, 0.76, 0.22, 0.16),
                (x + 0.02, 0.25, 0.74, 0.18, 0.14),
            ),
            color,
            y,
        )
        builder.loft(((x, 0.24, 0.32, 0.2, 0.2), (x + 0.34, 0.24, 0.32, 0.2, 0.2)), color, y)
        builder.loft(((x + 0.32, 0.3, 0.95, 0.24, 0.16), (x + 0.42, 0.3, 0.98, 0.22, 0.14)), color, y)
    else:
        builder.box((x - 0.02, y, 0.46), (0.52, 0.32, 0.34), (70, 72, 76))
        builder.loft(
            ((x - 0.08, 0.68, 0.82, 0.12, 0.08), (x + 0.16, 0.66, 0.94, 0.17, 0.12), (x + 0.42, 0.64, 0.86, 0.14, 0.1)),
            color,
            y,
        )
        builder.loft(((x - reach - 0.22, 0.72, 0.86, 0.06, 0.06), (x - 0.1, 0.62, 0.80, 0.12, 0.12)), color, y)
        if not cruiser:
            builder.loft(((x + 0.3, 0.42, 0.98, 0.2, 0.12), (x + reach - 0.02, 0.56, 0.92, 0.14, 0.08)), color, y)
        for side in (0.15, -0.15):
            builder.limb((x - reach - 0.1, y + side, 0.36), (x + 0.1, y + side, 0.34), 0.09, 0.09, STEEL)
    builder.box((x - 0.30, y, seat_z), (0.62, 0.26, 0.09), RUBBER)
    fork = (x + reach - 0.18, y, 0.98)
    for side in (0.09, -0.09):
        builder.limb((x + reach, y + side, radius), (fork[0], y + side, fork[2]), 0.05, 0.05, STEEL)
    builder.box((fork[0] - 0.02, y, 1.03), (0.06, 0.68, 0.05), RUBBER)
    builder.cylinder((fork[0] + 0.08, y, 0.9), (fork[0] + 0.2, y, 0.9), 0.11, (60, 62, 66), sides=8)
    builder.box((x - reach - 0.24, y, 0.6), (0.02, 0.22, 0.15), (236, 236, 226))
    return (x - 0.28, y, seat_z + 0.06)


def _rider(
    builder: Builder, type_id: str, box: Box, place: tuple[Point, float, float], pedal: float, *, motor: bool
) -> None:
    """Build a rider on the saddle, hands on the bar, feet on pedals or rests."""
    (sx, y, sz), reach, top = place
    h = 1.72
    head_z = top - 0.12 * h
    lean = 0.16 if motor else 0.20
    neck = (sx + lean + 0.14, y, head_z - 0.03)
    bar = (box.center.x + reach - (0.20 if motor else 0.12), 1.05)
    joints: dict[str, Point] = {"hips__C": (sx, y, sz + 0.06), "neck__C": neck, "Head__C": (neck[0] + 0.04, y, head_z)}
    crank = (box.center.x - 0.08, 0.30)
    for side, sign in (("L", -1.0), ("R", 1.0)):
        turn = 2 * math.pi * pedal + (0.0 if sign > 0 else math.pi)
        if motor:
            foot = (box.center.x - 0.02, y + sign * 0.2, 0.30)
        else:
            foot = (crank[0] + 0.17 * math.cos(turn), y + sign * 0.1, crank[1] + 0.17 * math.sin(turn) + 0.05)
        hip = (sx + 0.03, y + sign * 0.09, sz + 0.02)
        spread = 0.24 if motor else 0.12
        knee = ((hip[0] + foot[0]) / 2 + 0.26, y + sign * spread, (hip[2] + foot[2]) / 2 + 0.12)
        shoulder = (neck[0] - 0.02, y + sign * 0.19, neck[2] - 0.06)
        hand = (bar[0], y + sign * 0.24, bar[1] + 0.02)
        elbow = ((shoulder[0] + hand[0]) / 2 - 0.02, y + sign * 0.30, (shoulder[2] + hand[2]) / 2 - 0.08)
        joints |= {f"thigh__{side}": hip, f"leg__{side}": knee, f"foot__{side}": foot,
                   f"toe__{side}": (foot[0] + 0.12, foot[1], foot[2] - 0.02), f"arm__{side}": shoulder,
                   f"foreArm__{side}": elbow, f"hand__{side}": hand}  # fmt: skip
    look = clothes_of(type_id, "male", "rider")
    helmet: Color = (30, 30, 34) if motor else (236, 236, 240)
    dressed = Clothes(
        look.skin, helmet, (46, 46, 52) if motor else TOPS[len(type_id) % len(TOPS)], look.trousers, hat=helmet
    )
    builder.add(person(joints, h, dressed))
