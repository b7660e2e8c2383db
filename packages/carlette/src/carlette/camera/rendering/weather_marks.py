"""Rain as it streaks through the picture."""

from __future__ import annotations

import numpy as np

from carlette.camera.arrays import Bytes, Singles

STREAKS = 420


def rain_streaks(rain: float, frame: int) -> tuple[Singles, Bytes]:
    """Thin quads in the camera's frame; their places change with the frame, always in the same way."""
    random = np.random.default_rng(frame)
    count = int(STREAKS * rain)
    ahead = random.uniform(2.0, 12.0, count)
    across = random.uniform(-1.3, 1.3, count) * ahead
    up = random.uniform(-0.9, 0.9, count) * ahead
    length, half = random.uniform(0.25, 0.6, count), np.full(count, 0.006) * ahead / 3
    lean = 0.08 * length
    corners = np.empty((count, 4, 3), np.float32)
    for number, (side, low) in enumerate(((-1, 0), (1, 0), (1, 1), (-1, 1))):
        corners[:, number, 0] = ahead
        corners[:, number, 1] = across + side * half + low * lean
        corners[:, number, 2] = up - low * length
    corners = np.concatenate([corners, corners[:, ::-1]])
    colors = np.empty((2 * count, 4, 4), np.uint8)
    colors[:] = (226, 220, 214, 84)
    return np.ascontiguousarray(corners), colors
