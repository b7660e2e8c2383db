"""Compiles the loops of the rasteriser once, for the types with which they are called."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from carlette.camera.rendering.averaging import halved
from carlette.camera.rendering.raster import Raster
from carlette.camera.rendering.view import CameraView
from carlette.geometry import Pose


@lru_cache(maxsize=1)
def warm_up() -> None:
    """Draws one quad; after that, no call compiles anything."""
    raster = Raster()
    picture = raster.begin(CameraView(Pose(), 2, 2, 90.0))
    corners = np.array([[(5, 1, 1), (5, 1, -1), (5, -1, -1), (5, -1, 1)]], np.float32)
    raster.draw(corners, np.zeros((1, 4, 4), np.uint8))
    halved(picture)
