"""The solver's own time, which follows the stack's clock but never jumps."""

from __future__ import annotations

from stucksolver.scene import Status

LONGEST_TICK_S = 2.0
"""A step back, or a step forward longer than this, is a clock fault: no control loop ticks so slowly."""
FIRST_S = float("-inf")


class Timeline:
    """Gives each status a continuous time. Subtract `offset_s` from it to get the stack's time."""

    def __init__(self) -> None:
        self.offset_s = 0.0
        self.jump_s: float | None = None
        """How far the clock jumped at this tick (s); None if it did not."""
        self._last_s = FIRST_S

    @property
    def now_s(self) -> float | None:
        """The solver's own time at the last tick (s); None before the first."""
        return None if self._last_s == FIRST_S else self._last_s + self.offset_s

    def follow(self, status: Status) -> Status:
        """Return the status in the solver's own time; the same object if the clock has never jumped."""
        now = status.time_s
        passed = now - self._last_s
        first, self._last_s = self._last_s == FIRST_S, now
        if 0.0 <= passed <= LONGEST_TICK_S or first:
            self.jump_s = None
        else:
            self.jump_s = passed
            self.offset_s -= passed
        return status if self.offset_s == 0.0 else status.model_copy(update={"time_s": now + self.offset_s})
