"""Training targets and loss: each center is a Gaussian on its label's heatmap, with the box regressed at its peak.

The numbers are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional

from lab.perception.training.lidar.data import IGNORED
from stucksolver_perception.lidar.decode import VELOCITY_MPS
from stucksolver_perception.lidar.grid import GRID, BevGrid
from stucksolver_perception.lidar_labels import LABELS

HILL = 0.13
"""Standard deviation of a Gaussian, as a share of length plus width."""
LEAST_HILL, MOST_HILL = 0.55, 1.7
"""Bounds on the standard deviation (cells)."""
HILL_REACH = 5
"""Number of cells on each side over which a Gaussian is drawn."""
NEIGHBOR_WEIGHT = 0.3
"""Weight of the cells around the center cell. They learn the same box, because the peak may be predicted there."""
SAME_BACKWARDS = ("cone", "barrier", "debris")
"""Labels that look the same from behind: their yaw targets lie between -90 and 90 degrees."""
YAWLESS = ("cone", "debris")
"""Labels without a visible front: their yaw gets a very small weight."""
WEIGHTS = (1.0, 1.0, 1.0, 0.7, 0.7, 0.7, 0.7, 0.7, 0.6, 0.6)
"""Loss weights of the regressed values."""
MOVING_MPS, MOVING_WEIGHT = 0.5, 4.0
"""Speed above which the velocity of a body gets a larger weight (m/s), and that weight.

Most bodies in a recording are stationary. The loss is close to an L1 loss, whose optimum is the median. An uncertain
network would therefore always answer zero.
"""
BOX_WEIGHT = 1.0
"""Weight of the box loss."""
FOCUS, SOFTEN = 2.0, 4.0
"""Exponents of the focal loss (Law and Deng 2018, CornerNet; Zhou et al. 2019, CenterNet)."""
LEAST_COUNT = 4.0
"""Least count by which a label's loss is divided; otherwise it is its count in the batch."""


@dataclass(frozen=True, eq=False)
class Targets:
    """Training targets of b windows."""

    heat: Tensor
    """(b, labels, rows, columns): 1 in the cell of a center, decreasing around it."""
    counted: Tensor
    """(b, 1, rows, columns): 0 on bodies that are neither targets nor background."""
    place: Tensor
    """(k, 2): window and cell of each regression target, at centers and the cells next to them."""
    regressed: Tensor
    """(k, 10)."""
    weight: Tensor
    """(k, 10)."""


def targets(boxes: Tensor, labels: Tensor, grid: BevGrid = GRID) -> Targets:
    """Return targets from padded boxes (b, most, 10) and labels (b, most)."""
    x, y = (boxes[..., 0] - grid.x_min_m) / grid.cell_m, (boxes[..., 1] - grid.y_min_m) / grid.cell_m
    row, column = torch.floor(x).long(), torch.floor(y).long()
    inside = (row >= 0) & (row < grid.rows) & (column >= 0) & (column < grid.columns)
    taught = inside & (labels >= 0)
    window, which = torch.nonzero(taught, as_tuple=True)
    box, label = boxes[window, which], labels[window, which]
    row, column, x, y = row[window, which], column[window, which], x[window, which], y[window, which]
    heat = _hills(box, label, window, row, column, len(boxes), grid)
    counted = _counted(boxes, labels == IGNORED, grid)
    steps = torch.tensor([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)], device=boxes.device)
    rows, columns = row[:, None] + steps[:, 0], column[:, None] + steps[:, 1]
    there = (rows >= 0) & (rows < grid.rows) & (columns >= 0) & (columns < grid.columns)
    own, neighbors = torch.nonzero(there, as_tuple=True)
    rows, columns = rows[own, neighbors], columns[own, neighbors]
    regressed = _values(box, label)[own]
    regressed[:, 0], regressed[:, 1] = x[own] - rows - 0.5, y[own] - columns - 0.5
    weight = torch.tensor(WEIGHTS, device=boxes.device).expand(len(own), -1).clone()
    yawless = torch.tensor([name in YAWLESS for name in LABELS], device=boxes.device)[label[own]]
    weight[:, 6:8] *= torch.where(yawless, 0.05, 1.0)[:, None]
    moving = torch.linalg.vector_norm(box[own, 7:9], dim=1) > MOVING_MPS
    weight[:, 8:10] *= torch.where(moving, MOVING_WEIGHT, 1.0)[:, None]
    weight *= torch.where(neighbors == 4, 1.0, NEIGHBOR_WEIGHT)[:, None]
    return Targets(heat, counted, torch.stack([window[own], rows * grid.columns + columns], 1), regressed, weight)


def _values(box: Tensor, label: Tensor) -> Tensor:
    """Return (k, 10): regression targets of boxes (k, 10), without the offset from the cell."""
    backwards = torch.tensor([name in SAME_BACKWARDS for name in LABELS], device=box.device)[label]
    sine, cosine = torch.sin(box[:, 6]), torch.cos(box[:, 6])
    sign = torch.where(backwards & (cosine < 0), -1.0, 1.0)
    nothing = torch.zeros_like(sine)
    velocity = box[:, 7:9] / VELOCITY_MPS
    size = torch.log(box[:, 3:6].clamp(min=0.02))
    parts = [nothing, nothing, box[:, 2], *size.unbind(1), sine * sign, cosine * sign, *velocity.unbind(1)]
    return torch.stack(parts, dim=1)


def _hills(
    box: Tensor, label: Tensor, window: Tensor, row: Tensor, column: Tensor, windows: int, grid: BevGrid
) -> Tensor:
    sigma = (HILL * (box[:, 3] + box[:, 4]) / grid.cell_m).clamp(LEAST_HILL, MOST_HILL)
    reach = torch.arange(-HILL_REACH, HILL_REACH + 1, device=box.device)
    square = (reach[:, None] ** 2 + reach[None, :] ** 2).flatten()
    di, dj = torch.meshgrid(reach, reach, indexing="ij")
    rows, columns = row[:, None] + di.flatten(), column[:, None] + dj.flatten()
    there = (rows >= 0) & (rows < grid.rows) & (columns >= 0) & (columns < grid.columns)
    height = torch.exp(-square / (2.0 * sigma[:, None] ** 2))
    index = ((window * len(LABELS) + label)[:, None] * grid.rows + rows) * grid.columns + columns
    heat = torch.zeros(windows * len(LABELS) * grid.cells, device=box.device)
    heat.scatter_reduce_(0, index[there], height[there], "amax")
    return heat.reshape(windows, len(LABELS), grid.rows, grid.columns)


def _counted(boxes: Tensor, ignored: Tensor, grid: BevGrid) -> Tensor:
    """Return 0 on and around the ignored boxes: their area is sampled and dilated by one cell."""
    window, which = torch.nonzero(ignored, as_tuple=True)
    box = boxes[window, which]
    along = torch.linspace(-0.5, 0.5, 33, device=boxes.device)
    across = torch.linspace(-0.5, 0.5, 9, device=boxes.device)
    u, v = torch.meshgrid(along, across, indexing="ij")
    dx, dy = u.flatten() * box[:, 3:4], v.flatten() * box[:, 4:5]
    cos, sin = torch.cos(box[:, 6:7]), torch.sin(box[:, 6:7])
    rows = torch.floor((box[:, 0:1] + cos * dx - sin * dy - grid.x_min_m) / grid.cell_m).long()
    columns = torch.floor((box[:, 1:2] + sin * dx + cos * dy - grid.y_min_m) / grid.cell_m).long()
    there = (rows >= 0) & (rows < grid.rows) & (columns >= 0) & (columns < grid.columns)
    covered = torch.zeros(len(boxes), 1, grid.rows, grid.columns, device=boxes.device)
    windows = window[:, None].expand_as(rows)
    covered[windows[there], 0, rows[there], columns[there]] = 1.0
    return 1.0 - functional.max_pool2d(covered, 3, 1, 1)


def losses(heat: Tensor, box: Tensor, aim: Targets) -> tuple[Tensor, Tensor]:
    """Return the heatmap loss and the box loss, one scalar each."""
    heat, box = heat.float(), box.float()
    share = torch.sigmoid(heat).clamp(1e-5, 1.0 - 1e-5)
    top = aim.heat > 0.999
    hit = -torch.log(share) * (1.0 - share) ** FOCUS * top
    missed = -torch.log1p(-share) * share**FOCUS * (1.0 - aim.heat) ** SOFTEN * ~top * aim.counted
    count = top.sum(dim=(0, 2, 3)).float()
    maps = ((hit + missed).sum(dim=(0, 2, 3)) / count.clamp(min=LEAST_COUNT)).sum()
    predicted = box.flatten(2).transpose(1, 2)[aim.place[:, 0], aim.place[:, 1]]
    wrong = functional.smooth_l1_loss(predicted, aim.regressed, reduction="none", beta=0.05) * aim.weight
    return maps, BOX_WEIGHT * wrong.sum() / aim.weight[:, 0].sum().clamp(min=1.0)
