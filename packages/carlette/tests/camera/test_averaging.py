"""Antialiasing: each pixel is the mean of its four samples."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("numba")

from carlette.camera.rendering.quad_rasterizer import halved


def test_antialiasing_byte_is_mean_of_2_by_2_samples() -> None:
    """Each byte is the mean of two by two samples, rounded down."""
    samples = np.random.default_rng(1).integers(0, 2**32, (18, 34), dtype=np.uint32)
    samples[:2, :2] = 0xFFFFFFFF
    parts = samples.view(np.uint8).reshape(9, 2, 17, 2, 4).astype(int)
    assert (halved(samples).view(np.uint8).reshape(9, 17, 4) == parts.sum(axis=(1, 3)) // 4).all()
