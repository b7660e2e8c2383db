"""Run times of the stages of perception."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class StageLatency:
    """Run times of one stage (ms)."""

    runs: int
    median_ms: float
    p95_ms: float
    worst_ms: float


def latency(taken_ms: Sequence[float]) -> StageLatency | None:
    """Summarize the times of all runs (ms); None if there are none."""
    if not taken_ms:
        return None
    values = np.asarray(taken_ms, np.float64)
    return StageLatency(len(values), float(np.median(values)), float(np.percentile(values, 95)), float(values.max()))
