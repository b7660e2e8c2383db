"""The solver's own time, which follows the stack's clock but never jumps."""

from __future__ import annotations

from stucksolver.scene import Status

LONGEST_TICK_S = 2.0
"""A step back, or a step forward longer than this, is a clock fault: no control loop ticks so slowly."""
SAME_S = 1e-6
"""Times this close are equal: ticks are sums of tenths of a second."""
USUAL_TICK_S = 0.05
"""Assumed length of a tick before the clock has shown one (s): 20 Hz."""
STUCK_TICKS = 40
"""A clock that has not gone on for so many ticks does not run: 2 s at 20 Hz."""
GONE_ON_S = 1e-3
"""A clock runs if it goes on by this much within `STUCK_TICKS`: loops of up to 40 kHz. Ours."""
TELL_AGAIN_S = 1.0
"""Of jumps that follow each other within this time, only the first one is reported."""
NEVER_S = float("-inf")


class MonotonicTime:
    """Gives each status a continuous time. Subtract `offset_s` from it to get the stack's time."""

    def __init__(self) -> None:
        self.offset_s = 0.0
        self.jump_s: float | None = None
        """How far the clock jumped (s), on the first tick after it on which it runs; None on all others."""
        self.fault: str | None = None
        """Why the clock gives no time, and what to do; None if it runs. It stays the same while the fault lasts."""
        self._last_s = NEVER_S
        self._own_s = NEVER_S
        self._tick_s = USUAL_TICK_S
        self._guessed = False
        """True if the last tick had no time, so that the solver's own time was estimated."""
        self._gone_on_s = 0.0
        self._stuck_ticks = 0
        self._jumped_s: float | None = None
        self._jump_told_s = NEVER_S

    @property
    def now_s(self) -> float | None:
        """The solver's own time at the last tick (s); None before the first."""
        return None if self._own_s == NEVER_S else self._own_s

    def follow(self, status: Status) -> Status:
        """Return the status in the solver's own time; the same object if the clock has never jumped."""
        self.take(status.time_s)
        return status if self.offset_s == 0.0 else status.model_copy(update={"time_s": self._own_s})

    def take(self, now_s: float) -> None:
        """Take the stack's time of this tick (s)."""
        first, passed = self._last_s == NEVER_S, now_s - self._last_s
        self._last_s = now_s
        runs = first or -SAME_S <= passed <= LONGEST_TICK_S
        self._watch(0.0 if first else passed, runs)
        self.jump_s = None
        guessed, self._guessed = self._guessed, False
        ahead_s = now_s + self.offset_s - self._own_s
        if guessed:
            # The clock may have gone on meanwhile, and the estimate may be a little late or early.
            runs = abs(ahead_s) <= LONGEST_TICK_S
            self.offset_s -= 0.0 if 0.0 <= ahead_s <= LONGEST_TICK_S else ahead_s
        elif not runs:
            self.offset_s -= passed
        self._own_s = now_s + self.offset_s
        if not runs:
            self._jumped_s = passed if self._jumped_s is None else self._jumped_s
        elif passed > 0.0 and not first:
            self._tick_s = self._tick_s if guessed else passed
            self._tell_jump()

    def pass_on(self) -> float | None:
        """Estimate the solver's own time of a tick without a time (s), from the last tick; None before the first."""
        self.jump_s = None
        if self._own_s == NEVER_S:
            return None
        self._own_s += self._tick_s
        self._guessed = True
        return self._own_s

    def _tell_jump(self) -> None:
        """Report a jump once the clock runs again. One that does not run is a fault, and no series of jumps."""
        if self._jumped_s is not None and self._own_s - self._jump_told_s >= TELL_AGAIN_S:
            self.jump_s, self._jump_told_s = self._jumped_s, self._own_s
        self._jumped_s = None

    def _watch(self, passed_s: float, runs: bool) -> None:
        """Note whether the clock goes on."""
        self._gone_on_s += passed_s if runs else 0.0
        if self._gone_on_s >= GONE_ON_S:
            self._gone_on_s, self._stuck_ticks, self.fault = 0.0, 0, None
            return
        self._stuck_ticks += 1
        if self._stuck_ticks >= STUCK_TICKS and self.fault is None:
            how = (
                "stands still" if runs else "runs backwards" if passed_s < 0.0 else f"leaps by {passed_s:.3g} s a tick"
            )
            remedy = "give the time of each tick in seconds, from one clock that runs"
            self.fault = f"status.time_s {how}: it has not gone on for {STUCK_TICKS} ticks; {remedy}"
