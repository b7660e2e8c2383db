"""Decides whether a status can be used, and whether a fault of it is still to be reported."""

from __future__ import annotations

from stucksolver.scene import Status
from stucksolver.scene.plausibility import plausible_time_s, status_implausibility
from stucksolver.solver.monotonic_time import MonotonicTime

TELL_AGAIN_S = 10.0
"""A fault of a field is reported again only after this time without it (s): one that comes and goes is one fault."""


class StatusWatch:
    """Checks each status and follows its clock.

    Attributes:
        fault: Why this tick's status cannot be used, and what to give instead; None if it can.
        bad_s: For how long no status could be used (s, the solver's own time); 0 if this one can.
    """

    def __init__(self, timeline: MonotonicTime) -> None:
        self._timeline = timeline
        self._last: Status | None = None
        self._bad_since_s: float | None = None
        self._faulty_s: dict[str, float] = {}
        """When each field was last seen faulty (s, the solver's own time)."""
        self.fault: str | None = None
        self.bad_s = 0.0

    def follow(self, status: Status) -> Status | None:
        """Return the status in the solver's own time. If it cannot be used, return the last one that could, at the time
        of this one, estimated where it has none; None if there was none.
        """
        wrong = status_implausibility(status)
        self.fault = wrong
        if wrong is None:
            followed = self._timeline.follow(status)
            self.fault = self._timeline.fault
            if self.fault is None:
                self._last, self._bad_since_s, self.bad_s = followed, None, 0.0
                return followed
        time_s = None if wrong is None else plausible_time_s(status)
        if time_s is not None:
            self._timeline.take(time_s)
        lacks_time = time_s is None or self._timeline.fault is not None
        now = self._timeline.pass_on() if lacks_time else self._timeline.now_s
        if now is None or self._last is None:
            return None
        self._bad_since_s = now if self._bad_since_s is None else self._bad_since_s
        self.bad_s = now - self._bad_since_s
        return self._last.model_copy(update={"time_s": now})

    def is_news(self) -> bool:
        """True if this tick's fault was not reported a moment ago. Call it once for each tick with a fault."""
        assert self.fault is not None
        field, now = self.fault.split(" ")[0], self._timeline.now_s or 0.0
        last_s = self._faulty_s.get(field)
        self._faulty_s[field] = now
        return last_s is None or now - last_s > TELL_AGAIN_S
