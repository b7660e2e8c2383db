"""Paces a simulation to real time, and measures how late its ticks are."""

from __future__ import annotations

import time
from collections.abc import Callable

LATE_S = 0.025
"""Delay from which a tick counts as late (s): half a tick at 20 Hz. Ours."""


class RealTimePacer:
    """Call `wait` before each tick. `dt_s` is the tick's length (s)."""

    def __init__(
        self, dt_s: float, clock: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep
    ) -> None:
        self._dt_s = dt_s
        self._clock = clock
        self._sleep = sleep
        self._due_s: float | None = None
        self.ticks = 0
        self.late = 0
        self.behind_s: list[float] = []
        """Delay of each tick (s)."""

    def wait(self) -> None:
        """Sleep until the next tick is due. A late tick moves the schedule, so that delays do not add up."""
        now = self._clock()
        if self._due_s is None:
            self._due_s = now
        if now < self._due_s:
            self._sleep(self._due_s - now)
            now = self._clock()
        behind_s = now - self._due_s
        self.ticks += 1
        self.behind_s.append(behind_s)
        if behind_s >= LATE_S:
            self.late += 1
            self._due_s = now
        self._due_s += self._dt_s

    @property
    def worst_s(self) -> float:
        """Longest delay of a tick (s)."""
        return max(self.behind_s, default=0.0)
