"""Converts the network's strongest cells to boxes, one box per object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.lidar.grid import GRID, BevGrid
from stucksolver_perception.measurements import Detections, Floats, Singles

REGRESSED = 10
"""Per cell: x and y of the center relative to the cell (in cells), z (m), log of length, width and height, sine
and cosine of the yaw, velocity (in `VELOCITY_MPS`).
"""
VELOCITY_MPS = 5.0
SIZE_LIMIT = 3.5
"""Limit of the logarithm, so that a wild answer stays finite: 33 m."""
GROUPS = (0, 0, 1, 1, 1, 2, 2, 2)
"""Labels of one group cannot be at one place: vehicles, people who walk or ride, things on the road."""
NEAR_M = (1.2, 0.45, 0.35)
"""For each group: closer centers are one object (circle suppression; Yin et al. 2021)."""
INSIDE = 0.9
"""Nor can there be a center within this share of a better box of the same group."""


@dataclass(frozen=True)
class Calibration:
    """For each label: score = sigmoid(slope * logit + shift) (Platt 1999), and the lowest score that is reported."""

    slope: tuple[float, ...]
    shift: tuple[float, ...]
    least_score: tuple[float, ...]

    def __post_init__(self) -> None:
        for name in ("slope", "shift", "least_score"):
            if len(getattr(self, name)) != len(GROUPS):
                raise ValueError(f"{name}: {len(getattr(self, name))} values for {len(GROUPS)} labels")


def boxes_of(cell: NDArray[np.int64], regressed: Singles, grid: BevGrid = GRID) -> Floats:
    """Return boxes (n, 9): center x, y, z, length, width, height, yaw, velocity x and y (m, rad, m/s), vehicle frame.

    Args:
        cell: (n,) coarse cells.
        regressed: (n, 10), the network's output there, see `REGRESSED`.
    """
    told = regressed.astype(np.float64)
    boxes = np.empty((len(cell), 9))
    boxes[:, 0] = grid.x_min_m + (cell // grid.columns + 0.5 + told[:, 0]) * grid.cell_m
    boxes[:, 1] = grid.y_min_m + (cell % grid.columns + 0.5 + told[:, 1]) * grid.cell_m
    boxes[:, 2] = told[:, 2]
    boxes[:, 3:6] = np.exp(np.clip(told[:, 3:6], -SIZE_LIMIT, SIZE_LIMIT))
    boxes[:, 6] = np.arctan2(told[:, 6], told[:, 7])
    boxes[:, 7:9] = told[:, 8:10] * VELOCITY_MPS
    return boxes


def suppressed(label: NDArray[np.int64], score: Floats, boxes: Floats) -> NDArray[np.int64]:
    """Return the boxes that remain with one box per object, the best first.

    Args:
        label: (n,).
        score: (n,).
        boxes: (n, 9), see `boxes_of`.

    Returns:
        Indices of those that are neither near nor inside a better one of their group.
    """
    order = np.argsort(-score, kind="stable")
    group, box = np.array(GROUPS)[label[order]], boxes[order]
    dx, dy = box[None, :, 0] - box[:, None, 0], box[None, :, 1] - box[:, None, 1]
    cos, sin = np.cos(box[:, None, 6]), np.sin(box[:, None, 6])
    along, across = np.abs(cos * dx + sin * dy), np.abs(cos * dy - sin * dx)
    inside = (along < INSIDE * box[:, None, 3] / 2) & (across < INSIDE * box[:, None, 4] / 2)
    near = dx * dx + dy * dy < np.square(np.array(NEAR_M)[group])[:, None]
    rivals = (inside | near) & (group[:, None] == group[None, :])
    kept = np.ones(len(order), bool)
    for i in range(len(order)):
        if kept[i]:
            kept[i + 1 :] &= ~rivals[i, i + 1 :]
    return np.asarray(order[kept], np.int64)


def decode(
    logit: Singles,
    label: NDArray[np.int64],
    cell: NDArray[np.int64],
    regressed: Singles,
    time_s: float,
    calibration: Calibration,
    grid: BevGrid = GRID,
) -> Detections:
    """Return the detections of one run of the network, the best first.

    Args:
        logit: (k,) of the strongest cells.
        label: (k,) their labels.
        cell: (k,) their places.
        regressed: (k, 10) the network's output for the box there.
        time_s: Time of the detections (s).
        calibration: Calibration of this network.
        grid: Grid of this network.
    """
    slope, shift, least = (
        np.array(item)[label] for item in (calibration.slope, calibration.shift, calibration.least_score)
    )
    score = 1.0 / (1.0 + np.exp(-(slope * logit + shift)))
    strong = np.flatnonzero(score >= least)
    boxes = boxes_of(cell[strong], regressed[strong], grid)
    kept = suppressed(label[strong], score[strong], boxes)
    boxes = boxes[kept]
    return Detections(
        time_s, label[strong][kept], score[strong][kept], boxes[:, :3], boxes[:, 3:6], boxes[:, 6], boxes[:, 7:9]
    )
