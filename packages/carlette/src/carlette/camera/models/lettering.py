"""Block letters as quads, for signs, vehicles and the road."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from carlette.camera.models.mesh import Builder, Color, Point

_COLUMNS = {
    "0": "3E5149453E", "1": "00427F4000", "2": "4261514946", "3": "2141454B31", "4": "1814127F10", "5": "2745454539",
    "6": "3C4A494930", "7": "0171090503", "8": "3649494936", "9": "064949291E", "A": "7E1111117E", "B": "7F49494936",
    "C": "3E41414122", "D": "7F4141221C", "E": "7F49494941", "F": "7F09090901", "G": "3E4149497A", "H": "7F0808087F",
    "I": "00417F4100", "J": "2040413F01", "K": "7F08142241", "L": "7F40404040", "M": "7F020C027F", "N": "7F0408107F",
    "O": "3E4141413E", "P": "7F09090906", "Q": "3E4151215E", "R": "7F09192946", "S": "4649494931", "T": "01017F0101",
    "U": "3F4040403F", "V": "1F2040201F", "W": "3F4038403F", "X": "6314081463", "Y": "0708700807", "Z": "6151494543",
    "!": "00005F0000", "-": "0808080808", " ": "0000000000",
}  # fmt: skip
"""Five columns of seven dots for each letter, the lowest bit on top: the common font of dot displays."""
ADVANCE, ROWS = 6, 7


@lru_cache(maxsize=256)
def _runs(text: str) -> list[tuple[int, int, int]]:
    """Return (column, first row, row after the last) of the dots, with runs in a column merged."""
    runs = []
    for place, letter in enumerate(text):
        columns = bytes.fromhex(_COLUMNS.get(letter, _COLUMNS["-"]))
        for number, bits in enumerate(columns):
            row = 0
            while row < ROWS:
                start = row
                while row < ROWS and bits >> row & 1:
                    row += 1
                if row > start:
                    runs.append((place * ADVANCE + number, start, row))
                row += 1
    return runs


def lettering(
    builder: Builder,
    text: str,
    middle: Point,
    right: Point,
    up: Point,
    height_m: float,
    color: Color,
    *,
    glow: bool = False,
    width_m: float | None = None,
) -> None:
    """Write `text` (capitals and digits) around `middle`.

    `right` and `up` are unit vectors from the reader's point of view.

    `width_m` squeezes or stretches the whole line to that width.
    """
    dot_up = height_m / ROWS
    dots = len(text) * ADVANCE - 1
    dot_right = width_m / dots if width_m else dot_up
    r, u, m = np.array(right), np.array(up), np.array(middle)
    front = np.cross(r, u)
    # CARLA's frame is left-handed. The reader's right x up would point away from the reader in a right-handed one.
    towards = (-float(front[0]), -float(front[1]), -float(front[2]))
    for column, first, last in _runs(text.upper()):
        x0, x1 = (column - dots / 2) * dot_right, (column + 1 - dots / 2) * dot_right
        y0, y1 = (ROWS / 2 - first) * dot_up, (ROWS / 2 - last) * dot_up
        corners = [m + r * x + u * y for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
        builder.face([(float(c[0]), float(c[1]), float(c[2])) for c in corners], color, towards, glow=glow)
