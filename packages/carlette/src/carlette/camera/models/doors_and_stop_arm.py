"""Open doors, and the stop arm of a school bus."""

from __future__ import annotations

import math

from carlette.camera.models.lettering import lettering
from carlette.camera.models.mesh import Builder, Color, Mesh, shade
from carlette.camera.models.signs import BACK, RED, WHITE
from carlette.camera.models.vehicle_body import GLASS, frame_of
from carlette.camera.rendering import tags
from carlette.geometry import Box
from carlette.physics.doors import SIDE_DOORS, STOP_ARM

DOOR_M = 1.05
"""Width of a door (m). Ours."""
OPEN_DEG = 66.0
"""Opening angle of a door (degrees). Ours."""
INSIDE: Color = (58, 54, 52)
DARK: Color = (16, 16, 18)


def door_mesh(type_id: str, box: Box, door: int, swing: float, color: Color) -> Mesh:
    """Return one side door (0 to 3) turned about its hinge, with the dark opening behind it; 7 is the stop arm."""
    if door == STOP_ARM:
        return _stop_arm(type_id, box, swing)
    builder = Builder()
    frame = frame_of(type_id, box)
    place = SIDE_DOORS[door]
    x = box.center.x + place.along * box.extent.x
    side, wall = place.side, frame.y + place.side * frame.half
    height = frame.high - frame.low
    low, belt, top = frame.low + 0.2 * height, frame.low + 0.6 * height, frame.high - 0.10
    length = min(DOOR_M, 0.42 * box.extent.x)
    y = wall + side * 0.02
    builder.face([(x, y, low), (x - length, y, low), (x - length, y, belt), (x, y, belt)], DARK, (0, side, 0))
    builder.box((x - 0.55 * length, wall - side * 0.15, belt - 0.12), (0.3, 0.34, 0.45), (96, 90, 84))
    turn = math.radians(OPEN_DEG * swing)
    ahead, aside = -math.cos(turn), side * math.sin(turn)
    for z0, z1, outer, inner in ((low, belt, color, INSIDE), (belt, top, GLASS, shade(GLASS, 1.2))):
        lean = 0.12 if z0 == belt else 0.0
        near = (x, wall)
        far = (x + length * ahead, wall + length * aside)
        ring = [
            (near[0], near[1], z0),
            (far[0], far[1], z0),
            (far[0], far[1] - side * lean, z1 - lean),
            (near[0] - 0.1 * (lean > 0), near[1] - side * lean, z1),
        ]
        normal = (-aside, ahead, 0.0) if side < 0 else (aside, -ahead, 0.0)
        builder.face(ring, outer, normal)
        builder.face(
            [(p[0] - 0.03 * normal[0], p[1] - 0.03 * normal[1], p[2]) for p in ring],
            inner,
            (-normal[0], -normal[1], 0.0),
        )
    edge = (x + length * ahead, wall + length * aside)
    builder.box((edge[0], edge[1], (low + belt) / 2), (0.06, 0.06, belt - low), shade(color, 0.8))
    builder.box((edge[0], edge[1], low + 0.12), (0.09, 0.09, 0.12), (226, 30, 20), glow=True)
    return builder.mesh()


def _stop_arm(type_id: str, box: Box, swing: float) -> Mesh:
    """Return the octagon on its arm at the left side. The closed arm lies flat against the bus."""
    builder = Builder(tags.TRAFFIC_SIGN)
    frame = frame_of(type_id, box)
    x, y, z = box.center.x + 0.30 * box.extent.x, frame.y - frame.half - 0.04, 1.45
    turn = math.radians(90.0 * swing)
    ahead, aside = -math.cos(turn), -math.sin(turn)
    builder.limb((x, y, z), (x + 0.4 * ahead, y + 0.4 * aside, z), 0.06, 0.06, BACK)
    middle = (x + 0.8 * ahead, y + 0.8 * aside, z)
    for away in (1.0, -1.0):
        normal = (-aside * away, ahead * away, 0.0)
        for offset, radius, color in ((0.0, 0.40, WHITE), (0.012, 0.36, RED)):
            ring = []
            for number in range(8):
                angle = math.radians(22.5 + 45.0 * number)
                along, up = radius * math.cos(angle), radius * math.sin(angle)
                ring.append(
                    (
                        middle[0] + along * ahead + normal[0] * (offset + 0.01),
                        middle[1] + along * aside + normal[1] * (offset + 0.01),
                        middle[2] + up,
                    )
                )
            builder.face(ring, color, normal)
        reader = (-normal[1], normal[0], 0.0)
        spot = (middle[0] + normal[0] * 0.035, middle[1] + normal[1] * 0.035, middle[2])
        lettering(builder, "STOP", spot, (-reader[0], -reader[1], 0.0), (0, 0, 1.0), 0.24, WHITE)
    return builder.mesh()
