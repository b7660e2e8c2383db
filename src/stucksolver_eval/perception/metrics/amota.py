"""AMOTA: tracking accuracy averaged over recall, so that no threshold of confidence has to be chosen.

Weng et al., "AB3DMOT" (2020), as nuScenes scores tracking: at each level of recall r the misses that it allows are
taken off, MOTAR = max(0, 1 - (switches + false positives + misses - (1 - r) P) / (r P)), with P objects.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stucksolver_eval.perception.metrics.clear_mot import MotCounts, TrackedFrame, clear_mot

LEVELS = 40


def amota(drives: Sequence[Sequence[TrackedFrame]], within_m: float, levels: int = LEVELS) -> float | None:
    """Of one label over several drives, 0 to 1; None without objects. Levels that are not reached count 0."""
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
    """Counts at thresholds of the tracks' scores, the highest first."""
    scores = [frame.score for drive in drives for frame in drive]
    every = np.concatenate([np.zeros(0), *scores])
    if not len(every):
        return []
    chosen = sorted({float(one) for one in np.quantile(every, np.linspace(0.0, 1.0, levels), method="lower")})
    found = []
    for score in reversed(chosen):
        counts = (clear_mot([frame.at_least(score) for frame in drive], within_m) for drive in drives)
        found.append((score, sum(counts, MotCounts())))
    return found


def best_threshold(
    drives: Sequence[Sequence[TrackedFrame]], within_m: float, levels: int = LEVELS
) -> tuple[float, MotCounts] | None:
    """The threshold with the highest MOTA, and its counts, as nuScenes tells MOTA; None without objects or tracks."""
    told = [(score, counts) for score, counts in thresholds(drives, within_m, levels) if counts.mota is not None]
    return max(told, key=lambda one: -np.inf if one[1].mota is None else one[1].mota, default=None)


def _motar(counts: MotCounts, recall: float) -> float:
    errors = counts.switches + counts.false_positives + counts.misses - (1.0 - recall) * counts.objects
    return min(max(0.0, 1.0 - errors / (recall * counts.objects)), 1.0)
