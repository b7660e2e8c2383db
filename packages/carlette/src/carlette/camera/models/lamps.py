"""A vehicle's lit lamps, its light bar, the halos around the lamps, and the beams on the road."""

from __future__ import annotations

import itertools
import math
from enum import IntFlag

from carlette.camera.models.cycles import lamp_places
from carlette.camera.models.mesh import Builder, Color, Mesh, Point, shade
from carlette.camera.models.vehicle_body import BodyDimensions, body_kind, frame_of
from carlette.geometry import Box

BLINK_S, BLINK_LIT = 0.7, 0.7
"""Period of indicators (s), and the share of it in which they are lit. Ours."""
FLASH_S = 0.4
"""Half the period of flashing lights (s). Ours."""


class VehicleLights(IntFlag):
    """`carla.VehicleLightState`."""

    POSITION = 1
    LOW_BEAM = 2
    HIGH_BEAM = 4
    BRAKE = 8
    RIGHT_BLINKER = 16
    LEFT_BLINKER = 32
    REVERSE = 64
    FOG = 128
    INTERIOR = 256
    SPECIAL1 = 512
    SPECIAL2 = 1024


SPECIAL = VehicleLights.SPECIAL1 | VehicleLights.SPECIAL2
BLINKERS = VehicleLights.RIGHT_BLINKER | VehicleLights.LEFT_BLINKER
BEAMS = VehicleLights.LOW_BEAM | VehicleLights.HIGH_BEAM
WHITE: Color = (255, 252, 236)
RED: Color = (255, 26, 16)
AMBER: Color = (255, 158, 0)
BLUE: Color = (40, 90, 255)
BEAM: Color = (255, 244, 206)


def lit_lamps(flags: int, elapsed_s: float) -> tuple[int, int]:
    """Return which lights are lit at this time (indicators blink), and the phase of flashing lights (0 or 1)."""
    lit = flags & 0x7FF
    if (elapsed_s / BLINK_S) % 1.0 >= BLINK_LIT:
        lit &= ~int(BLINKERS)
    phase = int(elapsed_s / FLASH_S) % 2 if lit & int(SPECIAL) else 0
    return lit, phase


def lamp_meshes(type_id: str, box: Box, lit: int, phase: int) -> tuple[Mesh, Mesh]:
    """Return the lamps, and the halos of those that are lit."""
    lamps, halos = Builder(), Builder()
    frame = frame_of(type_id, box)
    state = VehicleLights(lit)
    for side in (1.0, -1.0):
        blinker = VehicleLights.RIGHT_BLINKER if side > 0 else VehicleLights.LEFT_BLINKER
        _front(lamps, halos, frame, side, state, bool(state & blinker))
        _rear(lamps, halos, frame, side, state, bool(state & blinker), body_kind(type_id) != "car")
    if state & VehicleLights.BRAKE and body_kind(type_id) == "car":
        lamps.box((frame.rear + 0.30, frame.y, frame.high - 0.10), (0.06, 0.5, 0.07), RED, glow=True)
    if state & VehicleLights.INTERIOR:
        lamps.plate((frame.middle, frame.y, frame.high + 0.011), (0.5, 0.3), (0, 0, 1), WHITE, glow=True)
    _bar(lamps, halos, type_id, frame, bool(state & SPECIAL), phase)
    return lamps.mesh(), halos.mesh()


def cycle_lamp_meshes(type_id: str, box: Box, wheelbase_m: float, lit: int) -> tuple[Mesh, Mesh]:
    """Return the lamps of a motorcycle, and the halos of those that are lit."""
    lamps, halos = Builder(), Builder()
    state = VehicleLights(lit)
    front, rear = lamp_places(type_id, box, wheelbase_m)
    beam, brake = bool(state & BEAMS), bool(state & VehicleLights.BRAKE)
    lamps.disc(
        front, 0.1, (1.0, 0, 0), WHITE if beam else (206, 212, 216), glow=bool(state & (BEAMS | VehicleLights.POSITION))
    )
    tail = bool(state & (VehicleLights.POSITION | BEAMS | VehicleLights.FOG))
    lamps.box(rear, (0.1, 0.2, 0.1), RED if brake else ((186, 16, 14) if tail else (104, 16, 16)), glow=brake or tail)
    for on, place, way, color in ((beam, front, 1.0, WHITE), (brake, rear, -1.0, RED)):
        if on:
            _halo(halos, (place[0] + 0.08 * way, place[1], place[2]), 0.42, (way, 0, 0), color)
    for side in (1.0, -1.0):
        blinks = bool(state & (VehicleLights.RIGHT_BLINKER if side > 0 else VehicleLights.LEFT_BLINKER))
        for place, way in ((front, 1.0), (rear, -1.0)):
            at = (place[0] - 0.06 * way, place[1] + 0.2 * side, place[2])
            lamps.box(at, (0.09, 0.11, 0.09), AMBER if blinks else (150, 92, 40), glow=blinks)
            if blinks:
                _halo(halos, (at[0] + 0.08 * way, at[1], at[2]), 0.4, (way, 0, 0), AMBER)
    return lamps.mesh(), halos.mesh()


def beam_mesh(type_id: str, box: Box, lit: int) -> Mesh:
    """Return the light that headlamps (and, in red, brake lamps) cast on the road.

    It is added to the picture in the dark.
    """
    builder = Builder()
    frame = frame_of(type_id, box)
    state = VehicleLights(lit)
    up: Point = (0.0, 0.0, 1.0)
    if state & BEAMS:
        reach = 42.0 if state & VehicleLights.HIGH_BEAM else 26.0
        start, half = frame.front + 0.4, frame.half
        cuts = ((0.0, 0.8, 0.2, 60), (0.22, 1.6, 0.9, 90), (0.6, 2.6, 1.8, 50), (1.0, 3.4, 2.4, 0))
        for (a, w0, e0, s0), (b, w1, e1, s1) in itertools.pairwise(cuts):
            x0, x1 = start + a * reach, start + b * reach
            core = [(x0, -half * w0, 0.1), (x0, half * w0, 0.1), (x1, half * w1, 0.1), (x1, -half * w1, 0.1)]
            builder.glowing(core, BEAM, up, [s0, s0, s1, s1])
            for side in (1.0, -1.0):
                y0, y1 = side * half * w0, side * half * w1
                wing = [
                    (x0, y0, 0.1),
                    (x0, y0 + side * half * e0, 0.1),
                    (x1, y1 + side * half * e1, 0.1),
                    (x1, y1, 0.1),
                ]
                builder.glowing(wing, BEAM, up, [s0, 0, 0, s1])
    if state & VehicleLights.BRAKE:
        half, x = frame.half, frame.rear
        ring = [(x, -half, 0.1), (x - 3.0, -half - 0.5, 0.1), (x - 3.0, half + 0.5, 0.1), (x, half, 0.1)]
        builder.glowing(ring, RED, up, [110, 0, 0, 110])
    return builder.mesh()


def _front(
    lamps: Builder, halos: Builder, frame: BodyDimensions, side: float, state: VehicleLights, blinks: bool
) -> None:
    y, x, z = frame.y + side * frame.lamp_half * 0.84, frame.front - 0.01, frame.lamp_z
    on = bool(state & BEAMS)
    color = WHITE if on else ((250, 246, 226) if state & VehicleLights.POSITION else (206, 212, 216))
    glow = bool(state & (BEAMS | VehicleLights.POSITION))
    lamps.box((x - 0.06, y, z), (0.16, 0.34, 0.17), color, glow=glow)
    if on:
        _halo(halos, (x + 0.06, y, z), 0.8 if state & VehicleLights.HIGH_BEAM else 0.48, (1.0, 0, 0), WHITE)
    if state & VehicleLights.FOG:
        lamps.box((x - 0.02, y, z - 0.26), (0.1, 0.2, 0.1), WHITE, glow=True)
    _indicator(lamps, halos, (x - 0.08, frame.y + side * (frame.lamp_half * 1.09), z), (1.0, side), blinks)


def _rear(
    lamps: Builder, halos: Builder, frame: BodyDimensions, side: float, state: VehicleLights, blinks: bool, heavy: bool
) -> None:
    y, x, z = frame.y + side * frame.lamp_half * 0.86, frame.rear - 0.02, frame.tail_z
    brake = bool(state & VehicleLights.BRAKE)
    tail = bool(state & (VehicleLights.POSITION | BEAMS | VehicleLights.FOG))
    color = RED if brake else ((186, 16, 14) if tail else (104, 16, 16))
    size = (0.18, 0.34, 0.20) if not heavy else (0.12, 0.26, 0.26)
    lamps.box((x + 0.05, y, z), size, color, glow=brake or tail)
    if brake:
        _halo(halos, (x - 0.08, y, z), 0.62, (-1.0, 0, 0), RED)
    reverse = bool(state & VehicleLights.REVERSE)
    inner = y - side * 0.27
    lamps.box((x + 0.05, inner, z - 0.03), (0.16, 0.17, 0.11), WHITE if reverse else (176, 172, 168), glow=reverse)
    if reverse:
        _halo(halos, (x - 0.08, inner, z - 0.03), 0.42, (-1.0, 0, 0), WHITE)
    _indicator(lamps, halos, (x + 0.06, frame.y + side * (frame.lamp_half * 1.09), z), (-1.0, side), blinks)


def _indicator(lamps: Builder, halos: Builder, place: Point, way: tuple[float, float], blinks: bool) -> None:
    """Build an indicator at a corner, visible from ahead or behind and from the side."""
    (x, y, z), (ahead, side) = place, way
    lamps.box((x, y, z), (0.24, 0.15, 0.16), AMBER if blinks else (150, 92, 40), glow=blinks)
    if blinks:
        _halo(halos, (x + 0.14 * ahead, y, z), 0.55, (ahead, 0, 0), AMBER)
        _halo(halos, (x, y + 0.09 * side, z), 0.45, (0, side, 0), AMBER)


def _bar(lamps: Builder, halos: Builder, type_id: str, frame: BodyDimensions, flashes: bool, phase: int) -> None:
    """Build the light bar of police, ambulance and fire engine, or the red lamps of a school bus."""
    if "schoolbus" in type_id:
        for x, side in ((frame.front - 1.44, 1.0), (frame.rear - 0.05, -1.0)):
            for number, aside in enumerate((0.82, -0.82)):
                on = flashes and number == phase
                at = (x, frame.y + aside * frame.half, frame.high - 0.34)
                lamps.disc(
                    (at[0] + 0.04 * side, at[1], at[2]), 0.12, (side, 0, 0), RED if on else (110, 20, 18), glow=on
                )
                if on:
                    _halo(halos, (at[0] + 0.08 * side, at[1], at[2]), 0.6, (side, 0, 0), RED)
        return
    if not any(word in type_id for word in ("police", "ambulance", "firetruck")):
        return
    half = min(0.62, frame.half * 0.62)
    police = "police" in type_id
    x = frame.middle - 0.10 * frame.length if police else frame.front - (1.5 if "ambulance" in type_id else 0.9)
    top = frame.high if police or "ambulance" in type_id else frame.low + 0.80 * (frame.high - frame.low)
    z = top + 0.06
    lamps.box((x, frame.y, z - 0.04), (0.26, 2 * half + 0.1, 0.07), (40, 42, 46))
    for number, aside in enumerate((-1.0, 1.0)):
        on = flashes and number == phase
        color = RED if number == 0 and police else BLUE
        at = (x, frame.y + aside * half * 0.56, z + 0.06)
        lamps.box(at, (0.24, half * 0.92, 0.15), color if on else shade(color, 0.72), glow=on)
        if on:
            for way in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)):
                _halo(halos, (at[0] + 0.16 * way[0], at[1], at[2]), 0.85, way, color)
    lamps.box((x, frame.y, z + 0.06), (0.2, half * 0.14, 0.13), (235, 235, 235))
    if "ambulance" in type_id or "firetruck" in type_id:
        for number, aside in enumerate((0.8, -0.8)):
            on = flashes and number == phase
            drop = 0.12 + 0.1 * (frame.high - frame.low) * ("firetruck" in type_id)
            at = (frame.rear + 0.02, frame.y + aside * frame.half, frame.high - drop)
            lamps.box(at, (0.14, 0.3, 0.16), BLUE if on else shade(BLUE, 0.7), glow=on)
            if on:
                _halo(halos, (at[0] - 0.1, at[1], at[2]), 0.6, (-1.0, 0, 0), BLUE)


def _halo(halos: Builder, place: Point, radius: float, towards: Point, color: Color) -> None:
    turns = [math.pi * item / 4 for item in range(8)]
    x, y, z = place
    if abs(towards[0]) > abs(towards[1]):
        ring = [(x, y + radius * math.cos(a), z + radius * math.sin(a)) for a in turns]
    else:
        ring = [(x + radius * math.cos(a), y, z + radius * math.sin(a)) for a in turns]
    halos.spot(place, ring, color, towards, 190)
