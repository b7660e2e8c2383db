"""AMOTA: tracking accuracy averaged over recall, which requires no choice of a confidence threshold.

Weng et al., "AB3DMOT" (2020), in the form of nuScenes: at each recall level r the allowed misses are subtracted, MOTAR
= max(0, 1 - (switches + false positives + misses - (1 - r) P) / (r P)), with P objects.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lab.perception.evaluation.metrics.clear_mot import MotCounts, TrackedFrame, clear_mot

LEVELS = 40
"""Number of recall levels, as in nuScenes."""


def amota(drives: Sequence[Sequence[TrackedFrame]], within_m: float, levels: int = LEVELS) -> float | None:
    """Return the AMOTA of one label over several drives, 0 to 1. Recall levels that are not reached count as 0.

    Args:
        drives: Frames of each drive, in order of time.
        within_m: Largest distance between a track and its object (m).
        levels: Number of recall levels.

    Returns:
        The AMOTA; None if there are no objects.
    """
    curve = [counts for _, counts in thresholds(drives, within_m, levels)]
    objects = max((counts.objects for counts in curve), default=0)
    if objects == 0:
        wanted = sum(int(frame.counted.sum()) for drive in drives for frame in drive)
        return None if wanted == 0 else 0.0
    total = 0.0
    for step in range(1, levels):
        recall = step / (levels - 1)
        reached = [counts for counts in curve if (counts.recall or 0.0) >= recall - 1e-9]
        if reached:
            # The highest threshold that reaches this recall.
            total += _motar(reached[0], recall)
    return total / (levels - 1)


def thresholds(
    drives: Sequence[Sequence[TrackedFrame]], within_m: float, levels: int = LEVELS
) -> list[tuple[float, MotCounts]]:
    """Return pairs of a score threshold and the counts of the tracks at or above it, highest threshold first."""
    scores = [frame.score for drive in drives for frame in drive]
    every = np.concatenate([np.zeros(0), *scores])
    if not len(every):
        return []
    chosen = sorted({float(item) for item in np.quantile(every, np.linspace(0.0, 1.0, levels), method="lower")})
    found = []
    for score in reversed(chosen):
        counts = (clear_mot([frame.at_least(score) for frame in drive], within_m) for drive in drives)
        found.append((score, sum(counts, MotCounts())))
    return found


def best_threshold(
    drives: Sequence[Sequence[TrackedFrame]], within_m: float, levels: int = LEVELS
) -> tuple[float, MotCounts] | None:
    """Return the threshold with the highest MOTA, and its counts, as nuScenes does; None without objects or tracks."""
    candidates = [(score, counts) for score, counts in thresholds(drives, within_m, levels) if counts.mota is not None]
    return max(candidates, key=lambda item: -np.inf if item[1].mota is None else item[1].mota, default=None)


def _motar(counts: MotCounts, recall: float) -> float:
    errors = counts.switches + counts.false_positives + counts.misses - (1.0 - recall) * counts.objects
    return min(max(0.0, 1.0 - errors / (recall * counts.objects)), 1.0)
