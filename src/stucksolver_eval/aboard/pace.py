"""Keeps a simulation at the pace of the clock on the wall, and says how well."""

from __future__ import annotations

import time
from collections.abc import Callable

LATE_S = 0.025
"""A tick that begins this much after its time is late: half a tick of 20 Hz."""


class Pace:
    """Call `wait` before each tick. `dt_s`: seconds from tick to tick."""

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
        """How much after its time each tick began."""

    def wait(self) -> None:
        """Sleep until the next tick is due. After a tick that came late the beat begins anew from it."""
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
        """The most that a tick began after its time."""
        return max(self.behind_s, default=0.0)
