"""The software rasterizer: a color buffer, a depth buffer, and quads that the CPU draws into them."""

from __future__ import annotations

from collections import OrderedDict
from functools import lru_cache

import numpy as np

from carlette.camera.arrays import Bytes, Pixels, Singles
from carlette.camera.rendering.view import FAR_M, CameraView
from carlette.geometry import Pose

KEPT_SIZES = 4
"""Number of picture sizes whose buffers are cached. Ours."""
_FARTHEST = np.float32(1.0 / FAR_M)


class Raster:
    """Draws quads into one picture at a time. One thread at a time may use it."""

    def __init__(self) -> None:
        self._buffers: OrderedDict[tuple[int, int], tuple[Pixels, Singles]] = OrderedDict()
        self._pixels: Pixels = np.empty((0, 0), np.uint32)
        self._nearness: Singles = np.empty((0, 0), np.float32)
        self._lens = (1.0, 1.0)
        self._matrix: Singles = np.eye(4, dtype=np.float32)
        self._adds, self._tests_depth = False, True

    def begin(self, view: CameraView, scale: int = 1) -> Pixels:
        """Begin a picture with an empty depth buffer, `scale` times as large in each direction as the view's.

        Returns the color buffer, uint32 (height, width), first row on top, its bytes in the order of `draw`'s colors.
        Fill it with a background, and copy all data that must outlive the next `begin`.
        """
        size = view.height * scale, view.width * scale
        if size not in self._buffers:
            if len(self._buffers) >= KEPT_SIZES:
                self._buffers.popitem(last=False)
            self._buffers[size] = np.empty(size, np.uint32), np.empty(size, np.float32)
        self._buffers.move_to_end(size)
        self._pixels, self._nearness = self._buffers[size]
        self._nearness.fill(_FARTHEST)
        across, up = view.tangents
        self._lens = across, up
        self._adds, self._tests_depth = False, True
        return self._pixels

    def draw(self, corners: Singles, colors: Bytes, matrix: Singles | None = None) -> None:
        """Draw quads: `corners` (n, 4, 3) float32, `colors` (n, 4, 4) uint8, four bytes per pixel, both contiguous.

        `matrix` (4x4) leads from their frame to the camera's; None = that of the last `transform_by` or `draw`. A
        quad's front points along (second - first) x (last - first); backs are not drawn. Where two quads are equally
        near, the first one stays.
        """
        from carlette.camera.rendering.quad_rasterizer import draw_quads  # numba takes half a second to load

        if matrix is not None:
            self.transform_by(matrix)
        shades = colors.view(np.uint32)[..., 0]
        draw_quads(
            corners, shades, self._matrix, *self._lens, self._adds, self._tests_depth, self._pixels, self._nearness
        )

    def transform_by(self, matrix: Singles) -> None:
        """Set the frame of all quads that are drawn without their own matrix."""
        self._matrix = np.ascontiguousarray(matrix, np.float32)

    def blend(self, *, add: bool = False) -> None:
        """Blend colors into the picture by their alpha from now on, as after `begin`, or add them to it as light.

        Added light never gets brighter than white: d + s (1 - d).
        """
        self._adds = add

    def use_depth(self, wanted: bool) -> None:
        """Set whether nearer objects hide the following quads."""
        self._tests_depth = wanted

    def depth(self) -> Singles:
        """Return distances ahead of the camera's plane (m): (height, width), 1000 where nothing was drawn."""
        meters: Singles = np.where(self._nearness > _FARTHEST, np.reciprocal(self._nearness), np.float32(FAR_M))
        return meters


@lru_cache(maxsize=1)
def warm_up() -> None:
    """Draw one quad. After that, no call compiles anything."""
    from carlette.camera.rendering.quad_rasterizer import halved  # numba takes half a second to load

    raster = Raster()
    picture = raster.begin(CameraView(Pose(), 2, 2, 90.0))
    corners = np.array([[(5, 1, 1), (5, 1, -1), (5, -1, -1), (5, -1, 1)]], np.float32)
    raster.draw(corners, np.zeros((1, 4, 4), np.uint8))
    halved(picture)
