"""Cuts crops out of the image: one small square for each box, with geometric features."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import CameraFrame, Floats, Pixels, Singles
from stucksolver_perception.rig import CameraRig

CROP_PX = 64
"""Side of a crop (px)."""
MARGIN = 1.25
"""Size of a crop relative to the box: tracks have errors, and halos of lamps and shadows help. Ours."""
MIN_SIZE_PX = 8.0
"""Minimum length of a box's longer side in the image (px); smaller boxes are not read. Ours."""
MIN_IN_VIEW = 0.35
"""Minimum share of a box's rectangle in the image. Ours."""
NEAREST_M = 0.5
"""Minimum distance of all corners of a box ahead of the lens (m). Ours."""
MAX_SAMPLES = 2
"""Approximate number of samples per pixel to which large crops are thinned first, for speed. Ours."""
FILL = 114
"""Gray value outside the image. Ours."""
FEATURES = 10
"""Number of columns of `features_of`."""
_SIGNS = np.array([[x, y, z] for x in (0.5, -0.5) for y in (0.5, -0.5) for z in (0.5, -0.5)])


@dataclass(frozen=True, eq=False)
class CropWindows:
    """The rectangles of n boxes in the image."""

    rectangle: Floats
    """(n, 4): left, top, right, bottom (px), cut at the image's edges."""
    in_view: Floats
    """(n,): share of the whole rectangle that is in the image."""
    usable: NDArray[np.bool_]
    """(n,): True if the rectangle is large enough, enough of it is in view, and the whole box is ahead."""

    @property
    def center(self) -> Floats:
        """(n, 2): column and row of the rectangles' centers (px)."""
        return (self.rectangle[:, :2] + self.rectangle[:, 2:]) / 2.0

    @property
    def side(self) -> Floats:
        """(n,): side of the square crops with the margin (px)."""
        longer = np.max(self.rectangle[:, 2:] - self.rectangle[:, :2], axis=1)
        return np.asarray(np.maximum(MARGIN * longer, 1.0))


def corners_of(boxes: Floats) -> Floats:
    """Return (n, 8, 3): the corners of boxes (n, 7) of center x, y, z, length, width, height (m), yaw (rad)."""
    local = _SIGNS[None] * boxes[:, None, 3:6]
    cos, sin = np.cos(boxes[:, 6, None]), np.sin(boxes[:, 6, None])
    rotated = np.stack(
        [local[..., 0] * cos - local[..., 1] * sin, local[..., 0] * sin + local[..., 1] * cos, local[..., 2]], axis=-1
    )
    return np.asarray(rotated + boxes[:, None, :3])


def windows_of(rig: CameraRig, boxes: Floats) -> CropWindows:
    """Return the rectangles of boxes (n, 7; see `corners_of`, vehicle frame) in the camera's image."""
    if not len(boxes):
        return CropWindows(np.zeros((0, 4)), np.zeros(0), np.zeros(0, bool))
    column, row, ahead = (item.reshape(-1, 8) for item in rig.project(corners_of(boxes).reshape(-1, 3)))
    whole = np.stack([column.min(1), row.min(1), column.max(1), row.max(1)], axis=1)
    limit = np.array([rig.width_px, rig.height_px, rig.width_px, rig.height_px], float)
    cut = np.clip(whole, 0.0, limit)
    sides = cut[:, 2:] - cut[:, :2]
    area = np.maximum(np.prod(whole[:, 2:] - whole[:, :2], axis=1), 1e-6)
    in_view = np.prod(sides, axis=1) / area
    fits = (sides.max(1) >= MIN_SIZE_PX) & (in_view >= MIN_IN_VIEW)
    return CropWindows(cut, in_view, fits & (ahead.min(1) > NEAREST_M))


def behind_dirt(windows: CropWindows, frame: CameraFrame) -> NDArray[np.bool_]:
    """Return (n,): True where known dirt on the lens touches the window."""
    if frame.covered is None:
        return np.zeros(len(windows.rectangle), bool)
    cell = np.array(frame.rgb.shape[1::-1]) / np.array(frame.covered.shape[::-1])
    first, last = windows.rectangle[:, :2] // cell, windows.rectangle[:, 2:] // cell + 1
    spans = np.concatenate([first, last], axis=1).astype(int).tolist()
    return np.array([frame.covered[top:bottom, left:right].any() for left, top, right, bottom in spans], bool)


def cut_crops(rgb: Pixels, center: Floats, side: Floats, pixels: int = CROP_PX) -> Pixels:
    """Return squares of an image, scaled to one size.

    Args:
        rgb: (height, width, 3).
        center: (n, 2) column and row of the squares' centers (px).
        side: (n,) sides of the squares (px).
        pixels: Side of the returned crops.

    Returns:
        (n, pixels, pixels, 3); the area outside the image is gray.
    """
    from PIL import Image

    crops = np.full((len(center), pixels, pixels, 3), FILL, np.uint8)
    height, width = rgb.shape[:2]
    for crop, (column, row), size in zip(crops, center.tolist(), side.tolist(), strict=True):
        scale = pixels / size
        left, top = column - size / 2.0, row - size / 2.0
        # The crop's pixels whose centers are in the image.
        first_x, last_x = _pixels_inside(left, size, width, pixels)
        first_y, last_y = _pixels_inside(top, size, height, pixels)
        if first_x >= last_x or first_y >= last_y:
            continue
        x0, x1 = max(left + first_x / scale, 0.0), min(left + last_x / scale, float(width))
        y0, y1 = max(top + first_y / scale, 0.0), min(top + last_y / scale, float(height))
        step = max(1, int(size / (MAX_SAMPLES * pixels)))
        c0, r0 = int(x0), int(y0)
        region = rgb[r0 : int(np.ceil(y1)) : step, c0 : int(np.ceil(x1)) : step]
        box = ((x0 - c0) / step, (y0 - r0) / step, (x1 - c0) / step, (y1 - r0) / step)
        box = (box[0], box[1], min(box[2], region.shape[1]), min(box[3], region.shape[0]))
        target = (last_x - first_x, last_y - first_y)
        resized = Image.fromarray(region).resize(target, Image.Resampling.BILINEAR, box=box)
        crop[first_y:last_y, first_x:last_x] = np.asarray(resized)
    return crops


def features_of(rig: CameraRig, boxes: Floats, windows: CropWindows) -> Singles:
    """Return the geometric features of each box: (n, 10), about -1 to 1.

    They are the logarithms of length, width, height, distance and of the crop's side in pixels; the share in view; the
    direction from the object to the lens in the object's frame (cosine, sine; 1, 0 if the lens is ahead of it); the
    height of its lower face above the road; and 1 for an object (crops of traffic lights have only zeros).
    """
    lens = rig.mount.to_vehicle()[:3, 3]
    offset = boxes[:, :2] - lens[:2]
    bearing = np.arctan2(-offset[:, 1], -offset[:, 0]) - boxes[:, 6]
    columns = [
        *np.log(np.maximum(boxes[:, 3:6], 0.05)).T / 3.0,
        np.log(np.maximum(np.hypot(offset[:, 0], offset[:, 1]), 1.0)) / 4.0,
        np.log(windows.side) / 6.0,
        windows.in_view,
        np.cos(bearing),
        np.sin(bearing),
        np.clip(boxes[:, 2] - boxes[:, 5] / 2.0, -3.0, 3.0) / 3.0,
        np.ones(len(boxes)),
    ]
    return np.stack(columns, axis=1).astype(np.float32)


def _pixels_inside(start: float, size: float, limit: int, pixels: int) -> tuple[int, int]:
    """Return the first pixel of a crop inside the image, and the one after the last, along one axis."""
    centers = start + (np.arange(pixels) + 0.5) * size / pixels
    first, last = np.searchsorted(centers, [0.0, float(limit)])
    return int(first), int(last)
