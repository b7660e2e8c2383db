"""Edges in an image that stay at the same pixels from look to look, and the pieces that they form."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Singles

Mask = NDArray[np.bool_]

EDGE = 4.0
"""Least difference of brightness (0 to 255) across two samples. Healthy drives are as clean with 2.5."""
MEMORY = 1.0 / 12.0
"""Weight of a new look."""
STAYS = 0.7
"""An edge stays if its mean direction is longer than this: after 14 looks that agree. On a grainy road, where edges are
random, chance brings one sample of 80 000 there.
"""
STILL = 0.55
"""The same for what is known: it may be hard to see for a while, and is gone after 7 looks without it."""
LEVEL = 0.25
"""In a row of samples with a larger share of edges that prove nothing, these are the horizon or other level lines."""


@dataclass
class StaticEdges:
    """The mean direction of the edge at each sample: its length is near 1 only if the same edge is there each time."""

    motion_x: Singles
    """(rows, columns): direction in which the scene moves at each sample, to the right ..."""
    motion_y: Singles
    """... and down."""
    right: Singles = field(init=False)
    down: Singles = field(init=False)

    def __post_init__(self) -> None:
        self.right, self.down = np.zeros_like(self.motion_x), np.zeros_like(self.motion_x)

    def add(self, samples: Singles) -> None:
        """Add a look: brightness at the samples, with a border of one more on each side. Rows may be left out below."""
        tall = samples[:-2] + 2.0 * samples[1:-1] + samples[2:]
        wide = samples[:, :-2] + 2.0 * samples[:, 1:-1] + samples[:, 2:]
        x, y = 0.25 * (tall[:, 2:] - tall[:, :-2]), 0.25 * (wide[2:] - wide[:-2])
        size = np.hypot(x, y)
        weight = np.where(size > EDGE, np.float32(MEMORY) / np.maximum(size, np.float32(EDGE)), np.float32(0.0))
        for mean, part in ((self.right[: len(x)], x), (self.down[: len(x)], y)):
            mean += weight * part - np.float32(MEMORY) * mean

    def staying(self, least: float = STAYS) -> Mask:
        """(rows, columns): where any edge stays."""
        return np.asarray(np.hypot(self.right, self.down) > least)

    def proving(self, least: float = STAYS) -> Mask:
        """(rows, columns): where an edge stays that lies across the scene's motion (by more than 45 degrees), which no
        edge of the scene can.
        """
        moving = self.right * self.motion_x + self.down * self.motion_y
        beside = self.right * self.motion_y - self.down * self.motion_x
        return np.asarray(self.staying(least) & (np.abs(moving) > np.abs(beside)))


def without_lines(edges: Mask, wide: float, thick: float) -> Mask:
    """Return the edges without pieces that are wider than `wide` and have fewer than `thick` samples in a column."""
    label, boxes = _pieces(edges)
    sizes = np.bincount(label.ravel(), minlength=len(boxes) + 1)
    widths = [columns.stop - columns.start for _, columns in boxes]
    lines = [k for k, width in enumerate(widths, 1) if width > wide and sizes[k] < thick * width]
    return np.asarray(edges & ~np.isin(label, lines))


def covered_by(edges: Mask, proof: Mask, least: int) -> tuple[Mask, float]:
    """Return where pieces are, as rectangles, and the share of the image that they take.

    An outline is rarely closed: where the scene is as bright as what stays, it has a gap. So a piece takes all of its
    rectangle. One that reaches the lower edge of the image is left out, and the horizon is no part of any.

    Args:
        edges: (rows, columns), all that stay.
        proof: Those of them that no scene has.
        least: Least number of the latter in a piece.
    """
    label, _ = _pieces(edges)
    edges = edges & ~np.isin(label, label[-1][edges[-1]])
    level = (edges & ~proof).mean(axis=1) > LEVEL
    label, boxes = _pieces(np.where(level[:, None], edges & proof, edges))
    proofs = np.bincount(label.ravel(), weights=proof.ravel(), minlength=len(boxes) + 1)
    covered, area = np.zeros(edges.shape, bool), 0
    for box, count in zip(boxes, proofs[1:], strict=True):
        if count >= least:
            covered[box] = True
            # An edge is seen from one sample beside it.
            area += math.prod(max(side.stop - side.start - 2, 1) for side in box)
    return covered, min(area / edges.size, 1.0)


def _pieces(edges: Mask) -> tuple[NDArray[np.int32], list[tuple[slice, slice]]]:
    """Number what is connected, also over corners, from 1 on, and return the rows and columns of each."""
    from scipy import ndimage  # type: ignore[import-untyped]

    label, _ = ndimage.label(edges, np.ones((3, 3)))
    return label, ndimage.find_objects(label)
