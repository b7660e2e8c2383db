"""Restores the LiDAR's network from the file that is shipped: `lidar.train --start lidar.onnx`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from torch import nn

from lab.perception.training.lidar.net import PillarNet
from lab.training.restore import Layer, Modules, restored_by


def restore(file: Path) -> PillarNet:
    """Return the network of an exported file; its batch normalisations change nothing but add the merged bias.

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
