"""Array types for pictures and meshes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Singles = NDArray[np.float32]
Pixels = NDArray[np.uint32]
"""Pixels with one whole color each."""
