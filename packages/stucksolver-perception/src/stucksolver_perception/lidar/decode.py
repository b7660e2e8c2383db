"""Converts the network's strongest cells to boxes, one per object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.lidar.grid import GRID, BevGrid
from stucksolver_perception.measurements import Detections, Floats, Singles

REGRESSION_SIZE = 10
"""Number of values per cell: x and y of the center relative to the cell (in cells), z (m), logarithms of length, width
and height, sine and cosine of the yaw, velocity (in units of `VELOCITY_MPS`)."""
VELOCITY_MPS = 5.0
"""Unit of the network's velocities (m/s)."""
SIZE_LIMIT = 3.5
"""Limit of a size's logarithm, so that any output is finite: 33 m. Ours."""
GROUPS = (0, 0, 1, 1, 1, 2, 2, 2)
"""Group of each label: vehicles; pedestrians, animals and two-wheelers; objects on the road. Two objects of a group
cannot be at the same position."""
NEAR_M = (1.2, 0.45, 0.35)
"""Distance of centers within which two boxes of a group are the same object (m), by group (circle suppression; Yin et
al. 2021). The values are ours."""
INNER_SHARE = 0.9
"""Inner part of a box that contains no center of another object of the same group. Ours."""


@dataclass(frozen=True)
class Calibration:
    """Calibration of each label: score = sigmoid(slope * logit + shift) (Platt 1999).

    Raises:
        ValueError: The number of values is not that of the labels.
    """

    slope: tuple[float, ...]
    shift: tuple[float, ...]
    least_score: tuple[float, ...]
    """Minimum score of a reported detection."""

    def __post_init__(self) -> None:
        for name in ("slope", "shift", "least_score"):
            if len(getattr(self, name)) != len(GROUPS):
                raise ValueError(f"{name}: {len(getattr(self, name))} values for {len(GROUPS)} labels")


def boxes_of(cell: NDArray[np.int64], regression: Singles, grid: BevGrid = GRID) -> Floats:
    """Return boxes (n, 9): center x, y, z, length, width, height, yaw, velocity x and y (m, rad, m/s; vehicle frame).

    Args:
        cell: (n,): coarse cells.
        regression: (n, 10): the network's output there; see `REGRESSION_SIZE`.
        grid: Grid of this network.
    """
    values = regression.astype(np.float64)
    boxes = np.empty((len(cell), 9))
    boxes[:, 0] = grid.x_min_m + (cell // grid.columns + 0.5 + values[:, 0]) * grid.cell_m
    boxes[:, 1] = grid.y_min_m + (cell % grid.columns + 0.5 + values[:, 1]) * grid.cell_m
    boxes[:, 2] = values[:, 2]
    boxes[:, 3:6] = np.exp(np.clip(values[:, 3:6], -SIZE_LIMIT, SIZE_LIMIT))
    boxes[:, 6] = np.arctan2(values[:, 6], values[:, 7])
    boxes[:, 7:9] = values[:, 8:10] * VELOCITY_MPS
    return boxes


def suppressed(label: NDArray[np.int64], score: Floats, boxes: Floats) -> NDArray[np.int64]:
    """Return the indices of the boxes with one box per object, the best first.

    A box is dropped if it is near or inside a better one of its group.

    Args:
        label: (n,): labels.
        score: (n,): scores.
        boxes: (n, 9): see `boxes_of`.
    """
    order = np.argsort(-score, kind="stable")
    group, box = np.array(GROUPS)[label[order]], boxes[order]
    dx, dy = box[None, :, 0] - box[:, None, 0], box[None, :, 1] - box[:, None, 1]
    cos, sin = np.cos(box[:, None, 6]), np.sin(box[:, None, 6])
    along, across = np.abs(cos * dx + sin * dy), np.abs(cos * dy - sin * dx)
    inside = (along < INNER_SHARE * box[:, None, 3] / 2) & (across < INNER_SHARE * box[:, None, 4] / 2)
    is_near = dx * dx + dy * dy < np.square(np.array(NEAR_M)[group])[:, None]
    is_rival = (inside | is_near) & (group[:, None] == group[None, :])
    remains = np.ones(len(order), bool)
    for i in range(len(order)):
        if remains[i]:
            remains[i + 1 :] &= ~is_rival[i, i + 1 :]
    return np.asarray(order[remains], np.int64)


def decode(
    logit: Singles,
    label: NDArray[np.int64],
    cell: NDArray[np.int64],
    regression: Singles,
    time_s: float,
    calibration: Calibration,
    grid: BevGrid = GRID,
) -> Detections:
    """Return the detections of one run of the network, the best first.

    Args:
        logit: (k,): logits of the strongest cells.
        label: (k,): their labels.
        cell: (k,): their numbers.
        regression: (k, 10): the network's output for the box there.
        time_s: Time of the detections (s).
        calibration: Calibration of this network.
        grid: Grid of this network.
    """
    slope, shift, min_score = (
        np.array(item)[label] for item in (calibration.slope, calibration.shift, calibration.least_score)
    )
    score = 1.0 / (1.0 + np.exp(-(slope * logit + shift)))
    strong = np.flatnonzero(score >= min_score)
    boxes = boxes_of(cell[strong], regression[strong], grid)
    best = suppressed(label[strong], score[strong], boxes)
    boxes = boxes[best]
    return Detections(
        time_s, label[strong][best], score[strong][best], boxes[:, :3], boxes[:, 3:6], boxes[:, 6], boxes[:, 7:9]
    )
