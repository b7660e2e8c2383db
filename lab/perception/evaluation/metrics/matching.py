"""Matches detections with objects: greedily in decreasing score, with the distance of centers on the ground.

It follows nuScenes (Caesar et al., "nuScenes: A multimodal dataset for autonomous driving", CVPR 2020), with one
difference: objects that are hardly detectable count neither as misses nor, if detected, as false positives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.measurements import Detections, Floats

Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
ANY_LABEL = -1
"""Label that stands for all labels."""


@dataclass(frozen=True, eq=False)
class TruthObjects:
    """Ground truth at one time, in the vehicle frame; all arrays have length n."""

    label: Indices
    """Index into `LABELS`; -1 for objects without a label, which are not counted and may have any detection."""
    center: Floats
    """Shape (n, 3) (m)."""
    size: Floats
    """Shape (n, 3): length, width, height (m)."""
    yaw: Floats
    """Shape (n,) (rad)."""
    velocity: Floats
    """Shape (n, 2): velocity over ground along the vehicle frame's axes (m/s)."""
    counted: Flags
    """False for objects with too few points."""
    identity: Indices
    """The actor's id."""

    def __len__(self) -> int:
        return len(self.label)


@dataclass(frozen=True, eq=False)
class Matches:
    """Detections of one label in all samples in decreasing score; arrays have length n unless stated."""

    score: Floats
    right: Flags
    sample: Indices
    detection: Indices
    """Index of the detection in its sample."""
    real: Indices
    """Index of the object in its sample; -1 for false positives."""
    range_m: Floats
    """Distance of the object from the ego (m); for false positives, that of the detection."""
    real_range_m: Floats
    """Shape (k,): distances of all objects that are counted, found or not (m)."""

    def between(self, nearest_m: float, farthest_m: float) -> Matches:
        """Return the matches in a range of distances from the ego (m)."""
        inside = (self.range_m >= nearest_m) & (self.range_m < farthest_m)
        wanted = (self.real_range_m >= nearest_m) & (self.real_range_m < farthest_m)
        return Matches(
            self.score[inside],
            self.right[inside],
            self.sample[inside],
            self.detection[inside],
            self.real[inside],
            self.range_m[inside],
            self.real_range_m[wanted],
        )


def match(found: Sequence[Detections], reals: Sequence[TruthObjects], label: int, within_m: float) -> Matches:
    """Match the detections of one label with the objects of that label, sample by sample.

    Args:
        found: Detections of each sample, in the vehicle frame.
        reals: Objects of the same samples.
        label: Index into `LABELS`.
        within_m: Largest distance of the centers of a detection and its object.

    Returns:
        One row for each detection, except those on objects that are not counted.
    """
    rows: list[tuple[float, bool, int, int, int, float]] = []
    ranges: list[Floats] = [np.zeros(0)]
    for sample, (detected, true) in enumerate(zip(found, reals, strict=True)):
        ranges.append(np.hypot(*true.center[(true.label == label) & true.counted, :2].T))
        rows += _rows(detected, true, label, within_m, sample)
    rows.sort(key=lambda row: -row[0])
    score, right, samples, detection, real, range_m = np.array(rows, np.float64).reshape(-1, 6).T
    sample_, detection_, real_ = (column.astype(np.int64) for column in (samples, detection, real))
    return Matches(score, right.astype(np.bool_), sample_, detection_, real_, range_m, np.concatenate(ranges))


def _rows(
    detected: Detections, true: TruthObjects, label: int, within_m: float, sample: int
) -> list[tuple[float, bool, int, int, int, float]]:
    mine = np.flatnonzero(detected.label == label)
    mine = mine[np.argsort(-detected.score[mine], kind="stable")]
    wanted = np.flatnonzero((true.label == label) & true.counted)
    spared = np.flatnonzero((true.label == ANY_LABEL) | ((true.label == label) & ~true.counted))
    reach_m = np.maximum(np.hypot(*true.size[spared, :2].T) / 2.0, within_m)
    free = np.ones(len(wanted), np.bool_)
    rows: list[tuple[float, bool, int, int, int, float]] = []
    for k in mine.tolist():
        away = np.hypot(*(true.center[wanted, :2] - detected.center[k, :2]).T)
        away = np.where(free, away, np.inf)
        best = int(np.argmin(away)) if len(away) else -1
        score = float(detected.score[k])
        if best >= 0 and away[best] < within_m:
            free[best] = False
            real = int(wanted[best])
            rows.append((score, True, sample, k, real, float(np.hypot(*true.center[real, :2]))))
        elif not (np.hypot(*(true.center[spared, :2] - detected.center[k, :2]).T) < reach_m).any():
            rows.append((score, False, sample, k, -1, float(np.hypot(*detected.center[k, :2]))))
    return rows
