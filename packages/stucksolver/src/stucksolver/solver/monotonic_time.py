"""The solver's own time, which follows the stack's clock but never jumps."""

from __future__ import annotations

from stucksolver.scene import Status

LONGEST_TICK_S = 2.0
"""Longest tick (s). A step back, or a longer step forward, is a clock fault: no control loop ticks so slowly. Ours."""
SAME_S = 1e-6
"""Difference below which times are equal (s): ticks are sums of tenths of a second."""
USUAL_TICK_S = 0.05
"""Assumed length of a tick before the clock has advanced (s): 20 Hz."""
STUCK_TICKS = 40
"""Number of ticks without an advance after which a clock counts as stopped: 2 s at 20 Hz. Ours."""
GONE_ON_S = 1e-3
"""Least advance of a running clock within `STUCK_TICKS` (s): loops of up to 40 kHz. Ours."""
TELL_AGAIN_S = 1.0
"""Time within which only the first of several jumps is reported (s). Ours."""
NEVER_S = float("-inf")


class MonotonicTime:
    """Continuous time for each status. Subtract `offset_s` from it to get the stack's time."""

    def __init__(self) -> None:
        self.offset_s = 0.0
        self.jump_s: float | None = None
        """Jump of the clock (s), on the first tick after it with a running clock; None on all other ticks."""
        self.fault: str | None = None
        """Fault of a clock that does not run, with the remedy; None if it runs. It is constant while the fault lasts.
        """
        self._last_s = NEVER_S
        self._own_s = NEVER_S
        self._tick_s = USUAL_TICK_S
        self._guessed = False
        """True if the last tick had no time, so that the solver's own time was estimated."""
        self._gone_on_s = 0.0
        self._stuck_ticks = 0
        self._jumped_s: float | None = None
        self._jump_reported_s = NEVER_S

    @property
    def now_s(self) -> float | None:
        """The solver's own time at the last tick (s); None before the first."""
        return None if self._own_s == NEVER_S else self._own_s

    def follow(self, status: Status) -> Status:
        """Return the status in the solver's own time; the same object if the clock has never jumped."""
        self.take(status.time_s)
        return status if self.offset_s == 0.0 else status.model_copy(update={"time_s": self._own_s})

    def take(self, now_s: float) -> None:
        """Update the solver's own time with the stack's time of this tick (s)."""
        first, passed = self._last_s == NEVER_S, now_s - self._last_s
        self._last_s = now_s
        runs = first or -SAME_S <= passed <= LONGEST_TICK_S
        self._watch(0.0 if first else passed, runs)
        self.jump_s = None
        guessed, self._guessed = self._guessed, False
        ahead_s = now_s + self.offset_s - self._own_s
        if guessed:
            # The clock may have advanced meanwhile, and the estimate may be a little late or early.
            runs = abs(ahead_s) <= LONGEST_TICK_S
            self.offset_s -= 0.0 if 0.0 <= ahead_s <= LONGEST_TICK_S else ahead_s
        elif not runs:
            self.offset_s -= passed
        self._own_s = now_s + self.offset_s
        if not runs:
            self._jumped_s = passed if self._jumped_s is None else self._jumped_s
        elif passed > 0.0 and not first:
            self._tick_s = self._tick_s if guessed else passed
            self._report_jump()

    def pass_on(self) -> float | None:
        """Estimate the solver's own time of a tick without a time (s), from the last tick; None before the first."""
        self.jump_s = None
        if self._own_s == NEVER_S:
            return None
        self._own_s += self._tick_s
        self._guessed = True
        return self._own_s

    def _report_jump(self) -> None:
        """Report a jump after the clock runs again. A clock that does not run is a fault, and no series of jumps."""
        if self._jumped_s is not None and self._own_s - self._jump_reported_s >= TELL_AGAIN_S:
            self.jump_s, self._jump_reported_s = self._jumped_s, self._own_s
        self._jumped_s = None

    def _watch(self, passed_s: float, runs: bool) -> None:
        """Check whether the clock advances."""
        self._gone_on_s += passed_s if runs else 0.0
        if self._gone_on_s >= GONE_ON_S:
            self._gone_on_s, self._stuck_ticks, self.fault = 0.0, 0, None
            return
        self._stuck_ticks += 1
        if self._stuck_ticks >= STUCK_TICKS and self.fault is None:
            how = (
                "does not advance"
                if runs
                else "runs backward"
                if passed_s < 0.0
                else f"leaps by {passed_s:.3g} s a tick"
            )
            remedy = "give the time of each tick in seconds, from one clock that runs"
            self.fault = f"status.time_s {how}: no valid time for {STUCK_TICKS} ticks; {remedy}"
