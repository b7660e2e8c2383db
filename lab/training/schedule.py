"""Common parts of the training runs of all networks: the average of the weights, and a learning rate."""

from __future__ import annotations

import numpy as np
import torch
from torch import nn


def average(averaged: nn.Module, net: nn.Module, keep: float) -> None:
    """Move the weights of `averaged` toward those of `net`; integer buffers such as counters are copied.

    Args:
        averaged: The moving average, of the same class as `net`.
        net: The network that is trained.
        keep: Decay: the share of the old average that stays, 0 to 1.
    """
    with torch.no_grad():
        for old, new in zip(averaged.state_dict().values(), net.state_dict().values(), strict=True):
            if old.is_floating_point():
                old.lerp_(new, 1.0 - keep)
            else:
                old.copy_(new)


def rate(done: float, warm_up: float) -> float:
    """Return the learning rate relative to its peak: a short rise, then a half cosine down.

    Args:
        done: Finished share of the training, 0 to 1.
        warm_up: Share of the training in which the rate rises.
    """
    if done < warm_up:
        return done / warm_up + 0.01
    return 0.5 * (1.0 + float(np.cos(np.pi * (done - warm_up) / (1.0 - warm_up)))) + 0.001
