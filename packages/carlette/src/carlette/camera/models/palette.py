"""Colors and outlines that props share."""

from __future__ import annotations

import math

from carlette.camera.models.mesh import Color
from carlette.geometry import Box

ORANGE: Color = (255, 96, 10)
CARTON: Color = (188, 142, 88)
WOOD: Color = (150, 106, 64)
STEEL: Color = (150, 154, 158)
GREEN: Color = (52, 110, 66)
DARK: Color = (44, 46, 50)
AMBER: Color = (255, 170, 10)
RING = ((1, 1), (1, -1), (-1, -1), (-1, 1))
"""Corners of a rectangle, in half sizes."""
EIGHT = [2 * math.pi * (item + 0.5) / 8 for item in range(8)]
"""Angles of an octagon's corners."""


def low_of(box: Box) -> float:
    """Return height of a box's lower side."""
    return box.center.z - box.extent.z
