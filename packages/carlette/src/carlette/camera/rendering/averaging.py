"""Averages two by two samples into one pixel, in compiled code: plain numpy took a sixth of the time of a picture."""

from __future__ import annotations

import numba
import numpy as np

from carlette.camera.arrays import Pixels
from carlette.jit import compiled

_MASK, _BYTE, _QUARTER = numba.uint32(0x00FF00FF), numba.uint32(8), numba.uint32(2)


def halved(samples: Pixels) -> Pixels:
    """The averages, rounded down, of each byte of two by two samples; (2 h, 2 w) becomes (h, w)."""
    picture = np.empty((samples.shape[0] // 2, samples.shape[1] // 2), np.uint32)
    _halve(samples, picture)
    return picture


@compiled
def _halve(samples: Pixels, picture: Pixels) -> None:
    for y in range(picture.shape[0]):
        upper, lower, row = samples[2 * y], samples[2 * y + 1], picture[y]
        for x in range(len(row)):
            a, b, c, d = upper[2 * x], upper[2 * x + 1], lower[2 * x], lower[2 * x + 1]
            even = (a & _MASK) + (b & _MASK) + (c & _MASK) + (d & _MASK)
            odd = ((a >> _BYTE) & _MASK) + ((b >> _BYTE) & _MASK) + ((c >> _BYTE) & _MASK) + ((d >> _BYTE) & _MASK)
            row[x] = ((even >> _QUARTER) & _MASK) | (((odd >> _QUARTER) & _MASK) << _BYTE)
