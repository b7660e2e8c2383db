"""The network: points to pillars, pillars to a bird's-eye view, bird's-eye view to object centers and boxes.

CenterPoint (Yin, Zhou, Krähenbühl 2021) on PointPillars (Lang et al. 2019), made small enough for two CPU cores: it has
one head for all labels, and joins the four pillars of a coarse cell before the first convolution.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional

from lab.training.restore import Layer, Modules, restored_by
from stucksolver_perception.lidar.decode import REGRESSION_SIZE
from stucksolver_perception.lidar.grid import GRID, BevGrid
from stucksolver_perception.lidar.pillars import FEATURES
from stucksolver_perception.lidar_labels import LABELS

WIDTHS = (32, 64, 96)
"""Channels at cells of 0.64, 1.28 and 2.56 m. Ours; multiples of 16, the block size of onnxruntime."""
PILLAR_WIDTH = 24
"""Number of features of a pillar. Ours."""
HEAD_WIDTH = 32
"""Channels of the head. Ours."""
PRIOR_LOGIT = -4.6
"""Initial logit of the heat.

Every cell predicts 1 % before training, so that the many empty cells do not dominate the first steps (Lin et al. 2017).
"""
STRONGEST = 200
"""Number of cells that the network outputs. Ours."""


class _Scatter(torch.autograd.Function):  # type: ignore[misc]
    """Scatters rows (n, width) to their positions (n,) in `base` with the maximum of rows at one position.

    It is exported as ONNX's ScatterND, which onnxruntime runs ten times faster than the ScatterElements that
    torch exports.
    """

    @staticmethod
    def forward(ctx: Any, rows: Tensor, place: Tensor, base: Tensor) -> Tensor:
        return base.scatter_reduce(0, place[:, None].expand_as(rows), rows, "amax")

    @staticmethod
    def symbolic(g: Any, rows: Any, place: Any, base: Any) -> Any:
        column = g.op("Unsqueeze", place, g.op("Constant", value_t=torch.tensor([1])))
        return g.op("ScatterND", base, column, rows, reduction_s="max").setType(base.type())


def _convolution(before: int, after: int, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(before, after, 3, stride, 1, bias=False), nn.BatchNorm2d(after, momentum=0.03), nn.ReLU(inplace=True)
    )


def _up(before: int, after: int) -> nn.Sequential:
    return nn.Sequential(nn.ConvTranspose2d(before, after, 2, 2, bias=False), nn.BatchNorm2d(after, momentum=0.03))


class PillarNet(nn.Module):
    """Predicts logits (b, labels, rows, columns) and regressed values (b, 10, rows, columns) for b windows."""

    def __init__(self, widths: tuple[int, int, int] = WIDTHS, grid: BevGrid = GRID) -> None:
        super().__init__()
        a, b, c = widths
        self.widths, self.grid = widths, grid
        self.point = nn.Sequential(
            nn.Linear(FEATURES, PILLAR_WIDTH), nn.ReLU(), nn.Linear(PILLAR_WIDTH, PILLAR_WIDTH), nn.ReLU()
        )
        # No bias, so that cells without points stay 0 and the detector can skip them.
        self.join = nn.Sequential(nn.Linear(4 * PILLAR_WIDTH, a, bias=False), nn.ReLU())
        self.first = _convolution(a, a)
        self.second = nn.Sequential(_convolution(a, b, 2), *(_convolution(b, b) for _ in range(3)))
        self.third = nn.Sequential(_convolution(b, c, 2), *(_convolution(c, c) for _ in range(3)))
        self.third_up, self.mix = _up(c, b), _convolution(b, b)
        self.second_up, self.head = _up(b, a), _convolution(a, HEAD_WIDTH)
        self.heat = nn.Conv2d(HEAD_WIDTH, len(LABELS), 1)
        self.box = nn.Conv2d(HEAD_WIDTH, REGRESSION_SIZE, 1)
        nn.init.constant_(self.heat.bias, PRIOR_LOGIT)

    def forward(self, features: Tensor, cell: Tensor, windows: int) -> tuple[Tensor, Tensor]:
        """Return logits and regressed values from point features (n, 8) and pillar indices (n,).

        See `lab.perception.training.lidar.pillars`.
        """
        # Coordinates require more precision than bfloat16. With autocast, only the convolutions use it.
        with torch.autocast(features.device.type, enabled=False):
            hidden = self.point(features)
            pillars = hidden.new_zeros(windows * self.grid.pillars, PILLAR_WIDTH)
            pillars = pillars.scatter_reduce(0, cell[:, None].expand_as(hidden), hidden, "amax")
            cells = self.join(pillars.reshape(windows * self.grid.cells, 4 * PILLAR_WIDTH))
        return self.maps(cells, windows)

    def maps(self, cells: Tensor, windows: int) -> tuple[Tensor, Tensor]:
        """Return logits and regressed values from coarse cells (windows * cells, width)."""
        x = cells.reshape(windows, self.grid.rows, self.grid.columns, self.widths[0]).permute(0, 3, 1, 2)
        x1 = self.first(x)
        x2 = self.second(x1)
        x2 = self.mix(functional.relu(x2 + self.third_up(self.third(x2))))
        hidden = self.head(functional.relu(x1 + self.second_up(x2)))
        return self.heat(hidden), self.box(hidden)


class ExportedPillarNet(nn.Module):
    """The network as exported: takes one window, returns the strongest cells."""

    def __init__(self, net: PillarNet) -> None:
        super().__init__()
        self.net = net

    def forward(self, features: Tensor, slot: Tensor, occupied: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return logit (k,), label (k,), coarse cell (k,) and regressed values (k, 10) of the strongest cells.

        Args:
            features: (n, 8), point features.
            slot: (n,), pillar indices, counted only over the coarse cells that contain points.
            occupied: (m,), indices of these cells.
        """
        net = self.net
        hidden = net.point(features)
        # Empty pillars are derived from the input: a constant would be written to the file as 10 MB of zeros.
        empty = torch.zeros_like(occupied, dtype=hidden.dtype)[:, None].expand(-1, 4 * PILLAR_WIDTH)
        pillars = _Scatter.apply(hidden, slot, empty.reshape(-1, PILLAR_WIDTH))
        cells = net.join(pillars.reshape(-1, 4 * PILLAR_WIDTH))
        nothing = torch.zeros_like(occupied[:1], dtype=hidden.dtype)[:, None].expand(net.grid.cells, net.widths[0])
        return strongest(*net.maps(_Scatter.apply(cells, occupied, nothing), 1))


def strongest(heat: Tensor, box: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Return the `STRONGEST` highest local maxima of one window (1, ...)."""
    around = functional.max_pool2d(heat, 3, 1, 1)
    peaks = torch.where(heat == around, heat, torch.full_like(heat, -20.0)).flatten()
    logit, index = torch.topk(peaks, STRONGEST)
    cells = heat.shape[2] * heat.shape[3]
    cell = index % cells
    regressed = box.reshape(REGRESSION_SIZE, cells).transpose(0, 1)[cell]
    return logit, torch.div(index, cells, rounding_mode="floor"), cell, regressed


def restore(file: Path) -> PillarNet:
    """Return the network of an exported file. Its batch normalizations only add the merged bias.

    Raises:
        RestoreError: The file cannot be read, or holds another network.
    """
    return restored_by(_empty, file, "LiDAR network", "lidar.onnx or lidar.pt")


def _empty(layers: Sequence[Layer]) -> tuple[PillarNet, Modules]:
    first, second, third = (layers[i][0].shape[0] for i in (3, 4, 8))
    net = PillarNet((first, second, third))
    return net, _in_order(net)


def _in_order(net: PillarNet) -> Modules:
    blocks = [net.first, *net.second, *net.third, net.third_up, net.mix, net.second_up, net.head]
    pairs: list[tuple[nn.Module, nn.BatchNorm2d | None]] = [(block[0], block[1]) for block in blocks]
    return [(net.point[0], None), (net.point[2], None), (net.join[0], None), *pairs, (net.heat, None), (net.box, None)]
