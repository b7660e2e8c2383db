"""The crop network in torch, and the augmentation of its training crops.

The numbers are ours.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import torch
from torch import Tensor, nn
from torch.nn import functional

from lab.training.restore import Layer, Modules, restored_by
from stucksolver_perception.camera.crop_network import HEADS
from stucksolver_perception.camera.crops import CROP_PX, FEATURES, FILL

WIDTHS = (24, 40, 80, 160)
"""Channels of the four scales."""
SQUEEZED = 48
"""Channels after the trunk."""
JOINED = 160
"""Width of the layer that joins trunk and features."""
TRUNK_WIDTH = 16 * SQUEEZED + 32
"""Width of the input of the heads."""
GESTURE_UNITS = 48
"""Width of the hidden layer of the head for gestures."""
SHIFT, ZOOM = 0.10, 0.18
"""Errors of a tracker's box, as fractions of the crop's side: of its center and of its side."""
COVERED = 0.2
"""Share of crops with a covered patch."""
LENGTH_FEATURES, BEARING = slice(0, 3), slice(6, 8)
"""Columns of the features: lengths and bearing."""
LEFT, RIGHT = 1, 2
"""Indices of the blinkers in `LAMPS`."""


class ResidualBlock(nn.Module):
    """A convolution with stride 2, followed by a residual convolution."""

    def __init__(self, before: int, after: int) -> None:
        super().__init__()
        self.down = nn.Sequential(nn.Conv2d(before, after, 3, 2, 1, bias=False), nn.BatchNorm2d(after), nn.ReLU())
        self.more = nn.Sequential(nn.Conv2d(after, after, 3, 1, 1, bias=False), nn.BatchNorm2d(after))

    def forward(self, x: Tensor) -> Tensor:
        """Map (n, before, h, w) to (n, after, h/2, w/2)."""
        x = self.down(x)
        return functional.relu(x + self.more(x))


class CropNet(nn.Module):
    """A trunk of convolutions down to 4x4, joined with the features, with one head per property."""

    def __init__(self) -> None:
        super().__init__()
        first = nn.Sequential(nn.Conv2d(3, WIDTHS[0], 5, 2, 2, bias=False), nn.BatchNorm2d(WIDTHS[0]), nn.ReLU())
        self.trunk = nn.Sequential(first, *(ResidualBlock(a, b) for a, b in itertools.pairwise(WIDTHS)))
        self.squeeze = nn.Sequential(nn.Conv2d(WIDTHS[-1], SQUEEZED, 1), nn.ReLU())
        self.geometry = nn.Sequential(nn.Linear(FEATURES, 32), nn.ReLU())
        self.join = nn.Sequential(nn.Linear(TRUNK_WIDTH, JOINED), nn.ReLU(), nn.Dropout(0.2))
        *joined, last = HEADS.values()
        self.heads = nn.ModuleList(nn.Linear(JOINED, size) for size in joined)
        # A separate head, so that it can be trained without a change of the other outputs.
        self.gesture = nn.Sequential(nn.Linear(TRUNK_WIDTH, GESTURE_UNITS), nn.ReLU(), nn.Linear(GESTURE_UNITS, last))

    def forward(self, pictures: Tensor, features: Tensor) -> tuple[Tensor, ...]:
        """Return logits of each head for images (n, 3, 64, 64; 0 to 1) and features (n, 10)."""
        both = self.trunk_outputs(pictures, features)
        joined = self.join(both)
        return (*(head(joined) for head in self.heads), self.gesture(both))

    def trunk_outputs(self, pictures: Tensor, features: Tensor) -> Tensor:
        """Return (n, `TRUNK_WIDTH`): the outputs of the trunk for images and features, the input of the heads."""
        # The square root brightens dark pixels, which matter at night.
        outputs = self.squeeze(self.trunk(pictures.clamp(min=1e-4).sqrt() * 2.0 - 1.0)).flatten(1)
        return torch.cat([outputs, self.geometry(features)], dim=1)


def restored(file: Path) -> CropNet:
    """Return the network of an exported file, for further training; a head that the file lacks is random.

    Raises:
        RestoreError: The file cannot be read, or holds another network.
    """
    return restored_by(_empty, file, "crop network", "crops.onnx")


def _empty(layers: Sequence[Layer]) -> tuple[CropNet, Modules]:
    net = CropNet()
    first, *blocks = net.trunk
    pairs: list[tuple[nn.Module, nn.BatchNorm2d | None]] = [(first[0], first[1])]
    for block in blocks:
        pairs += [(block.down[0], block.down[1]), (block.more[0], block.more[1])]
    pairs += [(net.squeeze[0], None), (net.geometry[0], None), (net.join[0], None)]
    pairs += [(head, None) for head in net.heads]
    # The first networks have no head for gestures.
    return net, pairs if len(layers) == len(pairs) else [*pairs, (net.gesture[0], None), (net.gesture[2], None)]


class ExportedCropNet(nn.Module):
    """The network as exported: takes crops in the form in which they are cut, (n, 64, 64, 3) bytes."""

    def __init__(self, net: CropNet) -> None:
        super().__init__()
        self.net = net

    def forward(self, crops: Tensor, features: Tensor) -> tuple[Tensor, ...]:
        """Return logits of each head."""
        outputs: tuple[Tensor, ...] = self.net(crops.permute(0, 3, 1, 2).float() / 255.0, features)
        return outputs


def middle(stored: Tensor) -> Tensor:
    """Return the part of stored crops (n, 96, 96, 3 bytes) that the runtime would cut: (n, 3, 64, 64; 0 to 1)."""
    edge = (stored.shape[1] - CROP_PX) // 2
    part = stored[:, edge : edge + CROP_PX, edge : edge + CROP_PX]
    return part.permute(0, 3, 1, 2).float() / 255.0


def augmented(stored: Tensor, features: Tensor, lamps: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Augment crops: shift and zoom the box, change the lighting, mirror, cover a part.

    Args:
        stored: (n, 96, 96, 3) bytes.
        features: (n, 10).
        lamps: (n, 5), lamp labels.

    Returns:
        Images (n, 3, 64, 64; 0 to 1) with their features and lamp labels.
    """
    n, device = len(stored), stored.device
    whole = stored.permute(0, 3, 1, 2).float() / 255.0
    flip = torch.rand(n, device=device) < 0.5
    zoom = (1.0 + ZOOM * (2.0 * torch.rand(n, device=device) - 1.0)) * CROP_PX / stored.shape[1]
    shift = 2.0 * SHIFT * (2.0 * torch.rand(n, 2, device=device) - 1.0)
    matrix = torch.zeros(n, 2, 3, device=device)
    matrix[:, 0, 0] = torch.where(flip, -zoom, zoom)
    matrix[:, 1, 1] = zoom
    matrix[:, :, 2] = shift
    grid = functional.affine_grid(matrix, [n, 3, CROP_PX, CROP_PX], align_corners=False)
    pictures = functional.grid_sample(whole - FILL / 255.0, grid, align_corners=False) + FILL / 255.0
    features, lamps = features.clone(), lamps.clone()
    objects = features[:, -1:] > 0.5
    noise = torch.zeros_like(features)
    noise[:, LENGTH_FEATURES] = 0.05 * torch.randn(n, 3, device=device)
    features = features + torch.where(objects, noise, torch.zeros_like(noise))
    features[flip, BEARING.stop - 1] *= -1.0
    turned = torch.rand(n, device=device) < 0.1  # a tracker may confuse rear and front
    features[turned, BEARING] *= -1.0
    swapped = lamps.clone()
    swapped[:, LEFT], swapped[:, RIGHT] = lamps[:, RIGHT], lamps[:, LEFT]
    pictures, covered = _relit(pictures)
    # A lamp may be under the covered patch.
    known = torch.where(flip[:, None], swapped, lamps).masked_fill(covered[:, None], -1)
    return pictures, features, known


def _relit(pictures: Tensor) -> tuple[Tensor, Tensor]:
    """Change brightness, contrast and color, add blur and noise, and cover a part of some images.

    It returns the images, and which of them are covered.
    """
    n, device = len(pictures), pictures.device

    def draw(*shape: int) -> Tensor:
        return 2.0 * torch.rand(n, *shape, device=device) - 1.0

    mean = pictures.mean(dim=(1, 2, 3), keepdim=True)
    pictures = (pictures - mean) * (1.0 + 0.25 * draw(1, 1, 1)) + mean * (1.0 + 0.25 * draw(1, 1, 1))
    pictures = pictures * (1.0 + 0.06 * draw(3, 1, 1))
    blurred = functional.avg_pool2d(pictures, 3, 1, 1, count_include_pad=False)
    pictures = torch.lerp(pictures, blurred, (0.5 + 0.5 * draw(1, 1, 1)) * (draw(1, 1, 1) > 0.4))
    pictures = pictures + 0.02 * torch.randn_like(pictures) * (0.5 + 0.5 * draw(1, 1, 1))
    steps = torch.linspace(-1.0, 1.0, CROP_PX, device=device)
    off_x, off_y = (steps - draw(1)).abs(), (steps - draw(1)).abs()
    patched = torch.rand(n, 1, device=device) < COVERED
    half = 0.25 * torch.rand(n, 1, device=device) * patched
    covered = ((off_y < half)[:, :, None] & (off_x < half)[:, None, :])[:, None]
    return torch.where(covered, torch.rand(n, 3, 1, 1, device=device), pictures).clamp(0.0, 1.0), patched[:, 0]
