"""Loads recordings into memory as windows of sweeps, with the boxes at the end of each window."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene import ObjectKind
from stucksolver_perception.lidar.grid import GRID
from stucksolver_perception.lidar_labels import LABEL_OF_KIND, LARGE_EMERGENCY_M
from stucksolver_perception.measurements import Floats
from stucksolver_perception.recording import CENTIMETERS_PER_M, KINDS, Recorded, Recording, recordings

HISTORY = 10
"""Number of sweeps in a window: half a second at 20 Hz."""
LEAST_HISTORY = 5
"""Number of sweeps below which a window is not used. Ours."""
EVERY = 2
"""Number of ticks between the ends of two windows. Ours."""
GAP_S = 0.075
"""Time between two ticks above which they belong to different stretches (s)."""
IGNORED = -1
"""Label of bodies that are neither targets nor background: without a label, or with too few returns."""
LEAST_POINTS = 3
"""Minimum number of returns in the last sweep for a box to become a target. Ours."""
MARGIN_M, ABOVE_GROUND_M = 0.05, 0.05
"""Margin around a box within which returns belong to it, and height above its bottom from which they do (m). Ours."""
OWN_BODY_M = 1.5
"""Distance from the ego's reference point below which a box is the ego itself (m). Ours."""
BOX = 10
"""Number of fields of a box.

They are center x, y, z, length, width, height, yaw, velocity x and y (vehicle frame), number of returns.
"""


@dataclass(frozen=True, eq=False)
class SweepWindows:
    """All sweeps of some recordings and their windows, with one row per tick or per window."""

    points: NDArray[np.int16]
    """(n, 3) centimeters."""
    intensity: NDArray[np.uint8]
    start: NDArray[np.int64]
    """(ticks + 1,): index in `points` at which the sweep of each tick starts."""
    time_s: Floats
    pose: Floats
    """(ticks, 3): x, y, yaw."""
    history: NDArray[np.int64]
    """(windows, HISTORY): ticks of each window, newest first; -1 for none."""
    boxes: tuple[NDArray[np.float32], ...]
    """(k, 10) for each window, see `BOX`."""
    labels: tuple[NDArray[np.int64], ...]
    """(k,) for each window."""

    def __len__(self) -> int:
        return len(self.history)


def load(folders: Sequence[Path], jobs: int, most: int | None = None, every: int = EVERY) -> SweepWindows:
    """Load every recording in some folders.

    Args:
        folders: Recordings or folders of recordings.
        jobs: Number of reading processes.
        most: Maximum number of windows per recording.
        every: Ticks between the ends of two windows.

    Raises:
        RecordingError: A folder has no recordings.
        ValueError: The recordings hold no window.
    """
    found = [recording.folder for folder in folders for recording in recordings(folder)]
    tasks = [(folder, most, every) for folder in found]
    if jobs > 1:
        with ProcessPoolExecutor(jobs, mp_context=get_context("fork")) as pool:
            parts = list(pool.map(_read, tasks))
    else:
        parts = [_read(task) for task in tasks]
    parts = [part for part in parts if len(part)]
    if not parts:
        raise ValueError(
            f"no stretch is long enough for a window: {', '.join(map(str, folders))}. Collect longer drives"
        )
    ticks = np.cumsum([0] + [len(part.time_s) for part in parts])
    points = np.cumsum([0] + [len(part.points) for part in parts])
    pairs = list(zip(parts, ticks.tolist(), points.tolist(), strict=False))
    return SweepWindows(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.intensity for part in parts]),
        np.concatenate([np.zeros(1, np.int64), *(part.start[1:] + first for part, _, first in pairs)]),
        np.concatenate([part.time_s for part in parts]),
        np.concatenate([part.pose for part in parts]),
        np.concatenate([np.where(part.history >= 0, part.history + first, -1) for part, first, _ in pairs]),
        tuple(boxes for part in parts for boxes in part.boxes),
        tuple(labels for part in parts for labels in part.labels),
    )


def _read(task: tuple[Path, int | None, int]) -> SweepWindows:
    folder, most, every = task
    recording = Recording(folder)
    ticks = [_Tick(tick) for file in recording.files for tick in recording.stretch(file)]
    histories: list[list[int]] = []
    run: list[int] = []
    first = 0
    for i, tick in enumerate(ticks):
        if run and not 0.0 < tick.time_s - ticks[run[-1]].time_s < GAP_S:
            run = []
        first = first if run else i
        run = [*run[-HISTORY + 1 :], i]
        # Count from the first full history, so that every long enough stretch has a window.
        if len(run) >= LEAST_HISTORY and (i - first - HISTORY + 1) % every == 0:
            histories.append([*run[::-1], *[-1] * (HISTORY - len(run))])
    if most is not None and len(histories) > most:
        histories = [histories[i] for i in np.linspace(0, len(histories) - 1, most).astype(int)]
    truths = [_truth(ticks, history) for history in histories]
    nothing = np.zeros((0, 3), np.int16), np.zeros(0, np.uint8)
    return SweepWindows(
        np.concatenate([nothing[0], *(tick.points for tick in ticks)]),
        np.concatenate([nothing[1], *(tick.intensity for tick in ticks)]),
        np.cumsum([0] + [len(tick.points) for tick in ticks]).astype(np.int64),
        np.array([tick.time_s for tick in ticks]),
        np.array([(*tick.pose[:2], tick.pose[3]) for tick in ticks]).reshape(-1, 3),
        np.array(histories, np.int64).reshape(-1, HISTORY),
        tuple(boxes for boxes, _ in truths),
        tuple(labels for _, labels in truths),
    )


class _Tick:
    """Stored data of one tick."""

    def __init__(self, tick: Recorded) -> None:
        self.time_s, self.pose = tick.time_s, np.asarray(tick.pose, np.float64)
        self.points = np.round(tick.sweep.points[:, :3] * CENTIMETERS_PER_M).astype(np.int16)
        self.intensity = np.round(tick.sweep.points[:, 3] * 255.0).astype(np.uint8)
        self.labels = np.array(
            [
                label_of(KINDS[kind], length)
                for kind, length in zip(tick.truth.kind, tick.truth.boxes[:, 4], strict=True)
            ],
            np.int64,
        )
        self.boxes = tick.truth.boxes


def label_of(kind: ObjectKind, length_m: float) -> int:
    """Return the index into `LABELS` of a body of this kind and length, or `IGNORED`."""
    if kind is ObjectKind.EMERGENCY and length_m > LARGE_EMERGENCY_M:
        kind = ObjectKind.TRUCK
    return LABEL_OF_KIND.get(kind, IGNORED)


def _truth(ticks: Sequence[_Tick], history: Sequence[int]) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Return boxes (k, 10) and labels (k,) at the end of a window, within the grid."""
    now = ticks[history[0]]
    boxes = vehicle_frame(now.boxes, now.pose)
    x, y = boxes[:, 0], boxes[:, 1]
    near = (x > GRID.x_min_m) & (x < GRID.x_max_m) & (y > GRID.y_min_m) & (y < GRID.y_max_m)
    near &= np.hypot(x, y) > OWN_BODY_M
    boxes, labels = boxes[near], now.labels[near].copy()
    swept = [now.points.astype(np.float32) / CENTIMETERS_PER_M]
    if history[1] >= 0:
        swept.append(_moved(ticks[history[1]], now))
    count = returns_in(boxes, np.concatenate(swept))
    labels[count < LEAST_POINTS] = IGNORED
    return np.concatenate([boxes, count[:, None]], axis=1).astype(np.float32), labels


def vehicle_frame(boxes: Floats, pose: Floats) -> Floats:
    """Return ground-truth boxes (k, 9) (see `BOX_COLUMNS`) in the frame of a vehicle at `pose` (see `Recorded.pose`).

    Returns:
        (k, 9): center x, y, z, length, width, height, yaw, velocity x and y; the first nine of `BOX`.
    """
    yaw, pitch, roll = pose[3:6]
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    cr, sr = math.cos(roll), math.sin(roll)
    flat = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    turn = flat @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]) @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    middle = (boxes[:, :3] - pose[:3]) @ turn
    velocity = boxes[:, 7:9] @ flat[:2, :2]
    heading = np.mod(boxes[:, 3:4] - yaw + math.pi, math.tau) - math.pi
    return np.concatenate([middle, boxes[:, 4:7], heading, velocity], axis=1)


def returns_in(boxes: Floats, points: NDArray[np.float32]) -> Floats:
    """Return the number of points (n, 3) in each box (k, 9; see `BOX`), without the ground below it."""
    found = np.zeros(len(boxes))
    for i, (x, y, z, length, width, height, yaw) in enumerate(boxes[:, :7].tolist()):
        reach = math.hypot(length, width) / 2 + MARGIN_M
        part = points[(np.abs(points[:, 0] - x) < reach) & (np.abs(points[:, 1] - y) < reach)]
        dx, dy, dz = part[:, 0] - x, part[:, 1] - y, part[:, 2] - z
        cos, sin = math.cos(yaw), math.sin(yaw)
        inside = (np.abs(cos * dx + sin * dy) < length / 2 + MARGIN_M) & (
            np.abs(cos * dy - sin * dx) < width / 2 + MARGIN_M
        )
        inside &= (dz > -height / 2 + ABOVE_GROUND_M) & (dz < height / 2 + MARGIN_M)
        found[i] = inside.sum()
    return found


def _moved(then: _Tick, now: _Tick) -> Any:
    """Return the points of one tick in the frame of a later one."""
    points = then.points.astype(np.float32) / CENTIMETERS_PER_M
    turn, yaw = then.pose[3] - now.pose[3], now.pose[3]
    dx, dy = then.pose[:2] - now.pose[:2]
    cos, sin = math.cos(turn), math.sin(turn)
    x = cos * points[:, 0] - sin * points[:, 1] + math.cos(yaw) * dx + math.sin(yaw) * dy
    y = sin * points[:, 0] + cos * points[:, 1] + math.cos(yaw) * dy - math.sin(yaw) * dx
    return np.stack([x, y, points[:, 2]], axis=1).astype(np.float32)
