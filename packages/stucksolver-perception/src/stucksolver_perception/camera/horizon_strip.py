"""Cuts out the strip of the image around the horizon, which contains far vehicles."""

from __future__ import annotations

import math

import numpy as np

from stucksolver_perception.measurements import CameraFrame, Floats, Pixels
from stucksolver_perception.rig import CameraRig

STRIP_ROWS = 192
"""Number of rows, half of them above the horizon. A far road stays inside if the slope changes by up to 8 %."""
STRIDE = 4
"""Pixels per cell of the network's output, in both directions."""
LABELS = ("vehicle", "two_wheeler", "person")
"""The detector's labels, which are coarser than those of the LiDAR."""
FILL = 114
"""Gray value outside the image. Ours."""
BAND_ROWS = 12
"""Number of rows above and below the horizon in which the contrast is measured: about a car's height at 150 m."""
RED_GREEN_BLUE = (299, 587, 114)
"""Weights of luminance in thousandths (ITU-R BT.601).

They are integers, whose sums are exact, so that every processor finds the same class of image (see
`camera_sight_distance.SightModel`).
"""


def horizon_row(rig: CameraRig, pitch_rad: float = 0.0) -> float:
    """Return the row in which a flat road ends.

    Args:
        rig: The camera.
        pitch_rad: Downward pitch of the vehicle relative to the road ahead (rad).
    """
    down_rad = math.radians(rig.mount.pitch_deg) + pitch_rad
    return rig.height_px / 2.0 - rig.focal_px * math.tan(down_rad)


def strip_top(rig: CameraRig, pitch_rad: float = 0.0) -> int:
    """Return the first row of the strip, which may be outside the image."""
    return round(horizon_row(rig, pitch_rad)) - STRIP_ROWS // 2


def is_dirty(frame: CameraFrame, rig: CameraRig) -> bool:
    """Return True if known dirt on the lens is in the strip, because it may cover a far vehicle in every image."""
    if frame.covered is None:
        return False
    top, cells = strip_top(rig), len(frame.covered)
    first, last = (max(row, 0) * cells // rig.height_px for row in (top, top + STRIP_ROWS - 1))
    return bool(frame.covered[first : last + 1].any())


def cut_rows(rgb: Pixels, top: int, rows: int) -> Pixels:
    """Return (rows, width, 3): the rows of an image from `top` on; gray outside."""
    height = len(rgb)
    if top >= 0 and top + rows <= height:
        return rgb[top : top + rows]
    strip = np.full((rows, *rgb.shape[1:]), FILL, np.uint8)
    first, last = max(top, 0), min(top + rows, height)
    if first < last:
        strip[first - top : last - top] = rgb[first:last]
    return strip


def look_of(strip: Pixels) -> Floats:
    """Return (2,): brightness of the band at the horizon (mean, 0 to 255), and its contrast.

    The contrast is the largest step of luminance (0 to 255) from one row to the next, as the median over the columns.
    By day it is 15 to 60, even on an empty plain, because the sky or houses meet the ground there. In fog and at night
    it is only a few units. Far cars are missed then, so recall is stored for both values (see `camera_sight_distance`).

    Args:
        strip: (`STRIP_ROWS`, width, 3), with the horizon in its middle.
    """
    center = len(strip) // 2
    band = strip[center - BAND_ROWS : center + BAND_ROWS].astype(np.int64) @ np.array(RED_GREEN_BLUE, np.int64)
    steps = np.abs(np.diff(band, axis=0)).max(axis=0)
    return np.array([float(band.mean()), float(np.median(steps))]) / sum(RED_GREEN_BLUE)
