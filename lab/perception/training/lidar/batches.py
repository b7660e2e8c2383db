"""Windows on the device: sweeps merged, augmented, and boxes padded to one size.

The numbers are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from lab.perception.training.lidar.data import BOX, IGNORED, SweepWindows
from stucksolver_perception.lidar.sweeps import CELL_M, CELLS, FLAT_M, LOW_M, MAX_POINTS, RECENT_S
from stucksolver_perception.recording import CENTIMETERS_PER_M

NO_BOX = -2
"""Label of padding."""
TURN_RAD = 0.35
"""Largest rotation of a window (rad)."""
SCALE = 0.05
"""Largest relative change of the scale."""
SHIFT_M, LIFT_M = 0.3, 0.08
"""Standard deviations of the horizontal and vertical shift, for another position and suspension height (m)."""
LEAST_KEPT = 0.7
"""Least share of the points that stays when points are dropped."""
RANGE_NOISE_M = 0.02
"""Standard deviation of the range noise (m)."""
POSE_NOISE_M, SPEED_NOISE_MPS, TURN_NOISE_RPS = 0.01, 0.05, 0.004
"""Standard deviations of localization noise: of each pose (m), and of the speed (m/s) and turn rate (rad/s).

The last two grow with age.
"""
FORGET = 0.15
"""Share of windows that lose some of their older sweeps, as right after a start."""


@dataclass(frozen=True, eq=False)
class WindowBatch:
    """A batch of windows."""

    points: Tensor
    """(n, 5): points of all windows, in the format of `SweepBuffer.gather`."""
    window: Tensor
    """(n,): the window of each point."""
    boxes: Tensor
    """(windows, most, 10), see `BOX`."""
    labels: Tensor
    """(windows, most); `IGNORED` or `NO_BOX` where there is no target."""


class WindowStore:
    """Windows stored on a device."""

    def __init__(self, windows: SweepWindows, device: torch.device) -> None:
        self.device = device
        self.points = torch.from_numpy(windows.points).to(device)
        self.intensity = torch.from_numpy(windows.intensity).to(device)
        self.start = torch.from_numpy(windows.start).to(device)
        self.history = torch.from_numpy(windows.history).to(device)
        self.pose = torch.from_numpy(windows.pose).to(device)
        self.time_s = torch.from_numpy(windows.time_s).to(device)
        most = max((len(boxes) for boxes in windows.boxes), default=0)
        padded = np.zeros((len(windows), max(1, most), BOX), np.float32)
        padded[:, :, 3:6] = 1.0
        labels = np.full(padded.shape[:2], NO_BOX, np.int64)
        for i, (boxes, window_labels) in enumerate(zip(windows.boxes, windows.labels, strict=True)):
            padded[i, : len(boxes)], labels[i, : len(boxes)] = boxes, window_labels
        self.boxes, self.labels = torch.from_numpy(padded).to(device), torch.from_numpy(labels).to(device)

    def __len__(self) -> int:
        return len(self.history)

    def batch(self, which: Tensor, vary: bool) -> WindowBatch:
        """Return the windows with these indices (b,), augmented for training if `vary`."""
        history = self.history[which]
        if vary:
            history = _forgetful(history)
        points, window = self._gathered(history, vary)
        boxes, labels = self.boxes[which], self.labels[which]
        if vary:
            points, window, boxes = varied(points, window, boxes)
        return WindowBatch(points, window, boxes, labels)

    def _gathered(self, history: Tensor, noisy: bool) -> tuple[Tensor, Tensor]:
        """Return the result of `SweepBuffer.gather` for each history (b, sweeps)."""
        known = history >= 0
        tick = history.clamp(min=0)
        first = self.start[tick]
        length = torch.where(known, self.start[tick + 1] - first, 0)
        age = (self.time_s[tick[:, :1]] - self.time_s[tick]).clamp(min=0.0)
        turn, dx, dy = _motion(self.pose[tick], age, noisy)
        slot = torch.repeat_interleave(length.flatten())
        begin = torch.cumsum(length.flatten(), 0) - length.flatten()
        index = torch.arange(len(slot), device=self.device) - begin[slot] + first.flatten()[slot]
        # Remove flat ground from older sweeps before anything else is computed for them.
        rough = (age <= RECENT_S).flatten()[slot] | _uneven(self.points[index], slot, history.numel())
        index, slot = index[rough], slot[rough]
        window = slot // history.shape[1]
        is_kept = _thinned(age.flatten()[slot] > RECENT_S, window, slot, len(history))
        index, slot, window = index[is_kept], slot[is_kept], window[is_kept]
        xyz = self.points[index].float() / CENTIMETERS_PER_M
        cos, sin = torch.cos(turn).flatten()[slot], torch.sin(turn).flatten()[slot]
        x = cos * xyz[:, 0] - sin * xyz[:, 1] + dx.flatten()[slot]
        y = sin * xyz[:, 0] + cos * xyz[:, 1] + dy.flatten()[slot]
        intensity = self.intensity[index].float() / 255.0
        return torch.stack([x, y, xyz[:, 2], intensity, age.flatten()[slot].float()], dim=1), window


def _uneven(points: Tensor, slot: Tensor, slots: int) -> Tensor:
    """`stucksolver_perception.lidar.sweeps.is_uneven` for points (n, 3; centimeters) of several sweeps."""
    place = points[:, :2].float() / CENTIMETERS_PER_M / torch.tensor(CELL_M, device=points.device)
    place = (torch.floor(place) + CELLS // 2).clamp(0, CELLS - 1).long()
    cell, z = (slot * CELLS + place[:, 0]) * CELLS + place[:, 1], points[:, 2].float()
    extremes = [
        torch.full((slots * CELLS * CELLS,), first, device=points.device).scatter_reduce_(0, cell, z, which)
        for first, which in ((float("inf"), "amin"), (float("-inf"), "amax"))
    ]
    uneven: Tensor = (z > LOW_M * CENTIMETERS_PER_M) | ((extremes[1] - extremes[0])[cell] > FLAT_M * CENTIMETERS_PER_M)
    return uneven


def _thinned(old: Tensor, window: Tensor, slot: Tensor, windows: int) -> Tensor:
    """Return which points stay: older sweeps are subsampled with a fixed step, as in `SweepBuffer`."""
    counts = torch.zeros(windows, 2, dtype=torch.int64, device=old.device)
    counts.view(-1).index_add_(0, 2 * window + old.long(), torch.ones_like(window))
    room = (MAX_POINTS - counts[:, 0]).clamp(min=1)
    step = ((counts[:, 1] + room - 1) // room).clamp(min=1)
    place = torch.arange(len(slot), device=old.device)
    sizes = torch.bincount(slot)
    place = place - (torch.cumsum(sizes, 0) - sizes)[slot]
    is_kept: Tensor = ~old | (place % step[window] == 0)
    return is_kept


def _motion(pose: Tensor, age: Tensor, noisy: bool) -> tuple[Tensor, Tensor, Tensor]:
    """Return rotation and translation (b, sweeps) that bring each sweep into the frame of the first."""
    yaw, turn = pose[:, :1, 2], pose[:, :, 2] - pose[:, :1, 2]
    dx, dy = pose[:, :, 0] - pose[:, :1, 0], pose[:, :, 1] - pose[:, :1, 1]
    along, across = torch.cos(yaw) * dx + torch.sin(yaw) * dy, torch.cos(yaw) * dy - torch.sin(yaw) * dx
    if noisy:
        older = (age > 0).to(age)
        drift = torch.randn(3, len(age), 1, device=age.device, dtype=age.dtype)
        along = along + SPEED_NOISE_MPS * drift[0] * age + POSE_NOISE_M * torch.randn_like(age) * older
        across = across + SPEED_NOISE_MPS * drift[1] * age + POSE_NOISE_M * torch.randn_like(age) * older
        turn = turn + TURN_NOISE_RPS * drift[2] * age
    return turn.float(), along.float(), across.float()


def _forgetful(history: Tensor) -> Tensor:
    """Truncate some histories."""
    count, most = history.shape
    length = torch.randint(2, most, (count, 1), device=history.device)
    whole = torch.rand(count, 1, device=history.device) >= FORGET
    age = torch.arange(most, device=history.device)
    return torch.where(whole | (age < length), history, -1)


def varied(points: Tensor, window: Tensor, boxes: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Mirror, rotate, scale and shift windows with their boxes, drop points and add noise."""
    count, device = len(boxes), boxes.device
    mirror = (torch.rand(count, device=device) < 0.5).float() * -2.0 + 1.0
    turn = (torch.rand(count, device=device) * 2.0 - 1.0) * TURN_RAD
    scale = 1.0 + (torch.rand(count, device=device) * 2.0 - 1.0) * SCALE
    shift = torch.randn(count, 3, device=device) * torch.tensor([SHIFT_M, SHIFT_M, LIFT_M], device=device)
    share = LEAST_KEPT + (1.0 - LEAST_KEPT) * torch.rand(count, device=device)
    noise = RANGE_NOISE_M * torch.rand(count, device=device)
    is_kept = torch.rand(len(points), device=device) < share[window]
    points, window = points[is_kept], window[is_kept]
    cos, sin = torch.cos(turn), torch.sin(turn)

    def moved(x: Tensor, y: Tensor, each: Tensor) -> tuple[Tensor, Tensor]:
        y = y * mirror[each]
        return (cos[each] * x - sin[each] * y) * scale[each], (sin[each] * x + cos[each] * y) * scale[each]

    x, y = moved(points[:, 0], points[:, 1], window)
    place = torch.stack([x, y, points[:, 2] * scale[window]], dim=1) + shift[window]
    place = place + torch.randn_like(place) * noise[window, None]
    points = torch.cat([place, points[:, 3:]], dim=1)
    all_windows = torch.arange(count, device=device)[:, None].expand(boxes.shape[:2])
    bx, by = moved(boxes[:, :, 0], boxes[:, :, 1], all_windows)
    vx, vy = moved(boxes[:, :, 7], boxes[:, :, 8], all_windows)
    middle = torch.stack([bx, by, boxes[:, :, 2] * scale[:, None]], dim=2) + shift[:, None]
    yaw = boxes[:, :, 6] * mirror[:, None] + turn[:, None]
    rest = torch.stack([yaw, vx, vy, boxes[:, :, 9]], dim=2)
    return points, window, torch.cat([middle, boxes[:, :, 3:6] * scale[:, None, None], rest], dim=2)


__all__ = ["IGNORED", "NO_BOX", "WindowBatch", "WindowStore", "varied"]
