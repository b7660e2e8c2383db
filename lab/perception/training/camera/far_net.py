"""The network that finds far vehicles in the strip around the horizon, and its loss.

After CenterNet (Zhou, Wang, Krähenbühl: Objects as Points, 2019): a heatmap whose peaks are box centers, and at each
peak the box's size, its exact center, its lower edge, and whether its front or its rear is visible.

The weights of the loss are ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import torch
from torch import Tensor, nn
from torch.nn import functional as fn

from lab.training.restore import Layer, Modules, restored_by
from stucksolver_perception.camera.horizon_strip import LABELS, STRIDE

CLASSES = len(LABELS)
CHANNELS = CLASSES + 6
"""Number of channels.

They are the heat of each label, log width and log height, horizontal and vertical offset of the center, offset of the
lower edge, all in cells, and the logit of facing toward the ego.
"""
WIDTHS = (16, 32, 48)
"""Channels at strides of 2, of 4, and of 8 and 16 pixels."""
MEAN, SPREAD = 9.0, 4.0
"""Approximate mean and spread of the square roots of pixels; normalizes them to about -2 to 2."""
SIGMA_SHARE = 0.17
"""Standard deviation of a Gaussian, as a fraction of the box's side."""
LEAST_SIGMA = 0.7
"""Smallest standard deviation of a Gaussian (cells)."""
PRIOR = -3.5
"""Initial logit of the heat: boxes are rare."""
AROUND = tuple((dx, dy) for dy in (-1, 0, 1) for dx in (-1, 0, 1))
"""Cells around a box's center that also learn its size, because the peak may be predicted next to its position."""
NEIGHBOR_WEIGHT = 0.3
"""Weight of the cells next to the center."""
SIZE_WEIGHT = 0.5
"""Weight in the loss of the error of log width and log height."""
MIDDLE_WEIGHT = 0.5
"""Weight of the error of the center (cells)."""
EDGE_WEIGHT = 1.0
"""Weight of the error of the lower edge, relative to half the box's height."""
TOWARDS_WEIGHT = 0.2
"""Weight of the error of the visible side, front or rear."""


def _step(inputs: int, outputs: int, stride: int = 1, kernel: int = 3) -> nn.Sequential:
    convolution = nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, bias=False)
    return nn.Sequential(convolution, nn.BatchNorm2d(outputs), nn.ReLU(inplace=True))


class _Block(nn.Module):
    """A residual block of two convolutions (He et al. 2016)."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.first, self.second = _step(channels, channels), _step(channels, channels)

    def forward(self, x: Tensor) -> Tensor:
        """Return an array of the same shape."""
        return x + self.second(self.first(x))


class FarNet(nn.Module):
    """Maps scaled images (n, 3, rows, width) to (n, `CHANNELS`, rows / 4, width / 4)."""

    def __init__(self, stem: int = WIDTHS[0], fine: int = WIDTHS[1], coarse: int = WIDTHS[2]) -> None:
        super().__init__()
        self.widths = (stem, fine, coarse)
        self.stem = _step(3, stem, 2)
        self.fine = nn.Sequential(_step(stem, fine, 2), _step(fine, fine))
        self.coarse = nn.Sequential(_step(fine, coarse, 2), _Block(coarse))
        self.coarsest = nn.Sequential(_step(coarse, coarse, 2), _Block(coarse))
        self.join, self.back = nn.Conv2d(coarse, coarse, 1), nn.Conv2d(coarse, fine, 1)
        self.head = _step(fine, fine)
        self.out = nn.Conv2d(fine, CHANNELS, 1)
        nn.init.constant_(self.out.bias[:CLASSES], PRIOR)

    def forward(self, x: Tensor) -> Tensor:
        """Return raw channels, heat logits first."""
        fine = self.fine(self.stem(x))
        coarse = self.coarse(fine)
        coarse = coarse + fn.interpolate(self.join(self.coarsest(coarse)), scale_factor=2.0, mode="nearest")
        joined = fine + fn.interpolate(self.back(coarse), scale_factor=2.0, mode="nearest")
        return self.out(self.head(joined))


def restored(file: Path) -> FarNet:
    """Return the network of an exported file, for further training.

    Raises:
        RestoreError: The file cannot be read, or holds another network.
    """
    return restored_by(_empty, file, "far detector", "far.onnx")


def _empty(layers: Sequence[Layer]) -> tuple[FarNet, Modules]:
    stem, fine, coarse = (layers[k][0].shape[0] for k in (0, 1, 3))
    net = FarNet(stem, fine, coarse)
    blocks = [net.stem, *net.fine, *_parts(net.coarse), *_parts(net.coarsest)]
    pairs: list[tuple[nn.Module, nn.BatchNorm2d | None]] = [(block[0], block[1]) for block in blocks]
    return net, [*pairs, (net.join, None), (net.back, None), (net.head[0], net.head[1]), (net.out, None)]


def _parts(scale: nn.Sequential) -> list[nn.Sequential]:
    step, block = scale
    return [step, block.first, block.second]


class ExportedFarNet(nn.Module):
    """The network that the runtime loads: takes bytes, returns heatmap peaks and the other channels."""

    def __init__(self, net: FarNet) -> None:
        super().__init__()
        self.net = net

    def forward(self, strip: Tensor) -> tuple[Tensor, Tensor]:
        """Return peaks (1, classes, h, w), 0 elsewhere, and the rest (1, 6, h, w), from bytes (1, rows, width, 3)."""
        raw = self.net(scaled(strip.permute(0, 3, 1, 2).float()))
        heat = torch.sigmoid(raw[:, :CLASSES])
        highest = fn.max_pool2d(heat, 3, 1, 1)
        return heat * (heat >= highest).float(), raw[:, CLASSES:]


def scaled(pixels: Tensor) -> Tensor:
    """Normalize the square roots of pixels (0 to 255), so that an unlit car at night also stands out."""
    return (torch.sqrt(pixels) - MEAN) / SPREAD


def loss_of(raw: Tensor, boxes: Tensor, shift: Tensor) -> Tensor:
    """Return the loss of a batch.

    Args:
        raw: (n, `CHANNELS`, h, w), network output.
        boxes: (n, m, 10), see `far_data.BOX_FIELDS`; missing rows are nan.
        shift: (n, 2), image column and row at which each strip starts (px).

    Returns:
        A scalar: focal loss of the heat plus absolute errors of the rest, per box.
    """
    rows, columns = raw.shape[2:]
    there = ~torch.isnan(boxes[..., 0])
    boxes = torch.nan_to_num(boxes)
    left, right = ((boxes[..., k] - shift[:, None, 0]) / STRIDE for k in (1, 3))
    top, bottom = ((boxes[..., k] - shift[:, None, 1]) / STRIDE for k in (2, 4))
    x, y = (left + right) / 2.0, (top + bottom) / 2.0
    inside = (x >= 0) & (x < columns) & (y >= 0) & (y < rows)
    taught = there & (boxes[..., 0] >= 0) & inside
    heat, weight = _targets(boxes[..., 0], taught, there, left, right, top, bottom, rows, columns)
    count = taught.sum().clamp(min=1)
    loss = _focal(raw[:, :CLASSES].float(), heat, weight) / count
    if not taught.any():
        return loss
    which, place = torch.nonzero(taught, as_tuple=True)
    x, y, bottom = x[which, place], y[which, place], bottom[which, place]
    sides = torch.stack([(right - left)[which, place], bottom - top[which, place]], 1)
    around = torch.tensor(AROUND, device=raw.device)
    cell_x, cell_y = x.floor().long() + around[:, :1], y.floor().long() + around[:, 1:]
    share = torch.where((around == 0).all(1, keepdim=True), 1.0, NEIGHBOR_WEIGHT)
    share = share * ((cell_x >= 0) & (cell_x < columns) & (cell_y >= 0) & (cell_y < rows))
    predicted = raw[which[None], CLASSES:, cell_y.clamp(0, rows - 1), cell_x.clamp(0, columns - 1)].float()
    middle = torch.stack([x - cell_x - 0.5, y - cell_y - 0.5], 2)
    error = SIZE_WEIGHT * (predicted[..., :2] - sides.clamp(min=0.25).log()).abs().sum(2)
    error = error + MIDDLE_WEIGHT * (predicted[..., 2:4] - middle).abs().sum(2)
    # An error of the lower edge matters less for tall boxes, which are near.
    error = error + EDGE_WEIGHT * (predicted[..., 4] - (bottom - cell_y - 0.5)).abs() / (sides[:, 1] / 2.0).clamp(
        min=1.0
    )
    front, facing = boxes[which, place, 7], boxes[which, place, 0] < 2
    target = front.clamp(min=0.0).expand_as(share)
    towards = fn.binary_cross_entropy_with_logits(predicted[..., 5], target, reduction="none")
    error = error + TOWARDS_WEIGHT * towards * ((front >= 0) & facing)
    return loss + (share * error).sum() / count


def _targets(
    label: Tensor,
    taught: Tensor,
    there: Tensor,
    left: Tensor,
    right: Tensor,
    top: Tensor,
    bottom: Tensor,
    rows: int,
    columns: int,
) -> tuple[Tensor, Tensor]:
    """Return heat (n, classes, rows, columns) with 1 at each center, and weights (n, 1, rows, columns), 0
    where unknown.
    """
    across = torch.arange(columns, device=label.device) + 0.5
    down = torch.arange(rows, device=label.device) + 0.5
    x, y = ((left + right) / 2.0).floor() + 0.5, ((top + bottom) / 2.0).floor() + 0.5
    wide = ((right - left) * SIGMA_SHARE).clamp(min=LEAST_SIGMA)[..., None]
    high = ((bottom - top) * SIGMA_SHARE).clamp(min=LEAST_SIGMA)[..., None]
    blob_x = torch.exp(-(((across - x[..., None]) / wide) ** 2) / 2.0)
    blob_y = torch.exp(-(((down - y[..., None]) / high) ** 2) / 2.0)
    heat = []
    for k in range(CLASSES):
        own = (taught & (label == k)).float()[..., None]
        heat.append(_highest(blob_y * own, blob_x))
    unknown = (there & (label < 0)).float()[..., None]
    edge_x = ((across > left[..., None] - 0.5) & (across < right[..., None] + 0.5)).float()
    edge_y = ((down > top[..., None] - 0.5) & (down < bottom[..., None] + 0.5)).float() * unknown
    stacked = torch.stack(heat, 1)
    weight = 1.0 - _highest(edge_y, edge_x)[:, None] * (stacked < 0.5).float()
    return stacked, weight


def _highest(down: Tensor, across: Tensor) -> Tensor:
    """Return (n, rows, columns): maximum over m outer products of a column (n, m, rows) and a row (n, m, columns)."""
    return (down[..., :, None] * across[..., None, :]).amax(1)


def _focal(logits: Tensor, heat: Tensor, weight: Tensor) -> Tensor:
    """Return the penalty-reduced focal loss of CenterNet (alpha 2, beta 4), summed."""
    p = torch.sigmoid(logits).clamp(1e-4, 1.0 - 1e-4)
    is_peak = (heat > 0.999).float()
    hit = -((1.0 - p) ** 2) * torch.log(p) * is_peak
    miss = -((1.0 - heat) ** 4) * p**2 * torch.log(1.0 - p) * (1.0 - is_peak)
    return ((hit + miss) * weight).sum()
