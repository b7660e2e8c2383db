"""The strip of the image around the horizon with far vehicles: its rows, and how it is cut out."""

from __future__ import annotations

import math

import numpy as np

from stucksolver_perception.measurements import CameraFrame, Floats, Pixels
from stucksolver_perception.rig import CameraRig

STRIP_ROWS = 192
"""Half of them above the horizon: on roads whose slope changes by up to 8 % the far end stays inside."""
STRIDE = 4
"""Pixels per cell of the network's output, in both directions."""
LABELS = ("vehicle", "two_wheeler", "person")
"""The detector's own labels, coarser than those of the LiDAR."""
FILL = 114
"""Gray beyond the image's edges."""
BAND_ROWS = 12
"""Rows on either side of the horizon in which contrast is measured: about the height of a car 150 m away."""
RED_GREEN_BLUE = (299, 587, 114)
"""Weights of luminance in thousandths (ITU-R BT.601).

Integers: sums of them are exact, so that every processor finds the same class of look (see `far_sight.SightModel`).
"""


def horizon_row(rig: CameraRig, pitch_rad: float = 0.0) -> float:
    """Return the row in which a flat road ends.

    Args:
        rig: The camera.
        pitch_rad: How far the vehicle's nose is down relative to the road ahead (rad).
    """
    down_rad = math.radians(rig.mount.pitch_deg) + pitch_rad
    return rig.height_px / 2.0 - rig.focal_px * math.tan(down_rad)


def strip_top(rig: CameraRig, pitch_rad: float = 0.0) -> int:
    """Return the image's row with which the strip begins; it may lie outside the image."""
    return round(horizon_row(rig, pitch_rad)) - STRIP_ROWS // 2


def is_dirty(frame: CameraFrame, rig: CameraRig) -> bool:
    """True if known dirt on the lens lies in the strip: a vehicle far away may be behind it in each image."""
    if frame.covered is None:
        return False
    top, cells = strip_top(rig), len(frame.covered)
    first, last = (max(row, 0) * cells // rig.height_px for row in (top, top + STRIP_ROWS - 1))
    return bool(frame.covered[first : last + 1].any())


def cut_rows(rgb: Pixels, top: int, rows: int) -> Pixels:
    """(rows, width, 3): rows of an image from `top` on; gray outside."""
    height = len(rgb)
    if top >= 0 and top + rows <= height:
        return rgb[top : top + rows]
    strip = np.full((rows, *rgb.shape[1:]), FILL, np.uint8)
    first, last = max(top, 0), min(top + rows, height)
    if first < last:
        strip[first - top : last - top] = rgb[first:last]
    return strip


def look_of(strip: Pixels) -> Floats:
    """(2,): brightness of the band at the horizon (mean, 0 to 255), and its contrast.

    The contrast is the largest step of luminance (0 to 255) from one row to the next, as the median over the columns.
    By day it is 15 to 60, even on an empty plain, since the sky or houses meet the ground there. Fog and night bring
    it down to a few. Far cars are missed then, so recall is stored by both (see `far_sight`).

    Args:
        strip: (`STRIP_ROWS`, width, 3), the horizon in its middle.
    """
    middle = len(strip) // 2
    band = strip[middle - BAND_ROWS : middle + BAND_ROWS].astype(np.int64) @ np.array(RED_GREEN_BLUE, np.int64)
    steps = np.abs(np.diff(band, axis=0)).max(axis=0)
    return np.array([float(band.mean()), float(np.median(steps))]) / sum(RED_GREEN_BLUE)
