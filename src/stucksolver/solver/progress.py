"""Watches whether the vehicle got going again: 15 m of new progress after the onset of an immobilization."""

from __future__ import annotations

from stucksolver.detect import Trigger
from stucksolver.scene import Status

RECOVERED_M = 15.0


class ProgressWatch:
    """Remembers where and when the present immobilization began."""

    def __init__(self, recovered_m: float = RECOVERED_M) -> None:
        self._recovered_m = recovered_m
        self._onset: tuple[float, float] | None = None

    @property
    def on(self) -> bool:
        """Is an immobilization going on that has not been recovered from?"""
        return self._onset is not None

    def update(self, status: Status, slow_since_s: float | None, trigger: Trigger | None) -> float | None:
        """Seconds from onset to recovery, at the tick at which the way is made; else None."""
        if self._onset is None:
            if trigger is not None:
                self._onset = (status.time_s if slow_since_s is None else slow_since_s, status.progress_m)
            return None
        onset_s, onset_m = self._onset
        if status.progress_m - onset_m < self._recovered_m:
            return None
        self._onset = None
        return status.time_s - onset_s
