"""Finds edges that stay at the same pixels in successive images, and the pieces that they form."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Singles

Mask = NDArray[np.bool_]

MIN_EDGE = 4.0
"""Minimum difference of brightness across two samples (0 to 255). Healthy drives are as clean with 2.5."""
LOOK_WEIGHT = 1.0 / 12.0
"""Weight of a new image. Ours."""
STATIC_LENGTH = 0.7
"""Length of the mean direction from which an edge stays. It is reached after 14 equal images. On a grainy road with
random edges, one sample of 80,000 reaches it by chance."""
KNOWN_LENGTH = 0.55
"""Length of the mean direction down to which known dirt is still there. It is left after 7 images without the edge."""
LEVEL_SHARE = 0.25
"""Share of edges without proof in a row of samples above which they are the horizon or other level lines. Ours."""


@dataclass
class StaticEdges:
    """The mean direction of the edge at each sample. Its length is near 1 only for the same edge in all images."""

    motion_x: Singles
    """(rows, columns): component to the right of the scene's direction of motion at each sample."""
    motion_y: Singles
    """(rows, columns): component down of that direction."""
    right: Singles = field(init=False)
    """(rows, columns): component to the right of the edge's mean direction."""
    down: Singles = field(init=False)
    """(rows, columns): component down of that direction."""

    def __post_init__(self) -> None:
        self.right, self.down = np.zeros_like(self.motion_x), np.zeros_like(self.motion_x)

    def add(self, samples: Singles) -> None:
        """Add an image: brightness at the samples, with a border of one sample on each side.

        Rows at the lower end may be missing.
        """
        tall = samples[:-2] + 2.0 * samples[1:-1] + samples[2:]
        wide = samples[:, :-2] + 2.0 * samples[:, 1:-1] + samples[:, 2:]
        x, y = 0.25 * (tall[:, 2:] - tall[:, :-2]), 0.25 * (wide[2:] - wide[:-2])
        size = np.hypot(x, y)
        weight = np.where(
            size > MIN_EDGE, np.float32(LOOK_WEIGHT) / np.maximum(size, np.float32(MIN_EDGE)), np.float32(0.0)
        )
        for mean, component in ((self.right[: len(x)], x), (self.down[: len(x)], y)):
            mean += weight * component - np.float32(LOOK_WEIGHT) * mean

    def staying(self, min_length: float = STATIC_LENGTH) -> Mask:
        """Return (rows, columns): True for edges that stay."""
        return np.asarray(np.hypot(self.right, self.down) > min_length)

    def proving(self, min_length: float = STATIC_LENGTH) -> Mask:
        """Return (rows, columns): True for edges that stay although they are across the scene's motion.

        Their angle to the motion is more than 45 degrees. No edge of the scene itself can stay there.
        """
        along_motion = self.right * self.motion_x + self.down * self.motion_y
        across_motion = self.right * self.motion_y - self.down * self.motion_x
        return np.asarray(self.staying(min_length) & (np.abs(along_motion) > np.abs(across_motion)))


def without_lines(edges: Mask, wide: float, thick: float) -> Mask:
    """Return the edges without pieces that are wider than `wide` and have fewer than `thick` samples in a column."""
    label, boxes = _pieces(edges)
    sizes = np.bincount(label.ravel(), minlength=len(boxes) + 1)
    widths = [columns.stop - columns.start for _, columns in boxes]
    lines = [k for k, width in enumerate(widths, 1) if width > wide and sizes[k] < thick * width]
    return np.asarray(edges & ~np.isin(label, lines))


def covered_by(edges: Mask, proof: Mask, min_length: int) -> tuple[Mask, float]:
    """Return the rectangles of the pieces as a mask, and their share of the image.

    An outline is rarely closed: it has gaps where the scene is as bright as the dirt. So a piece covers its whole
    rectangle. A piece that reaches the lower edge of the image is left out, and the horizon is part of no piece.

    Args:
        edges: (rows, columns), all edges that stay.
        proof: The edges that cannot belong to the scene.
        least: Minimum number of proving samples in a piece.
    """
    label, _ = _pieces(edges)
    edges = edges & ~np.isin(label, label[-1][edges[-1]])
    level = (edges & ~proof).mean(axis=1) > LEVEL_SHARE
    label, boxes = _pieces(np.where(level[:, None], edges & proof, edges))
    proofs = np.bincount(label.ravel(), weights=proof.ravel(), minlength=len(boxes) + 1)
    covered, area = np.zeros(edges.shape, bool), 0
    for box, count in zip(boxes, proofs[1:], strict=True):
        if count >= min_length:
            covered[box] = True
            # An edge is detected one sample beyond its position, on each side.
            area += math.prod(max(side.stop - side.start - 2, 1) for side in box)
    return covered, min(area / edges.size, 1.0)


def _pieces(edges: Mask) -> tuple[NDArray[np.int32], list[tuple[slice, slice]]]:
    """Return the connected pieces, numbered from 1, also connected over corners, and the rows and columns of each."""
    from scipy import ndimage  # type: ignore[import-untyped]

    label, _ = ndimage.label(edges, np.ones((3, 3)))
    return label, ndimage.find_objects(label)
