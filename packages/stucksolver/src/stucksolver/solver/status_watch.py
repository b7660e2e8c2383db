"""Decides whether a status is usable, and whether a fault in it must be reported."""

from __future__ import annotations

from stucksolver.scene import Status
from stucksolver.scene.plausibility import plausible_time_s, status_implausibility
from stucksolver.solver.monotonic_time import MonotonicTime

TELL_AGAIN_S = 10.0
"""Time without a fault after which the same fault is reported again (s): an intermittent fault is one fault. Ours."""


class StatusWatch:
    """Check of each status and of its clock.

    Attributes:
        fault: Fault of this tick's status with the remedy; None if the status is usable.
        bad_s: Time without a usable status (s, the solver's own time); 0 if this one is usable.
    """

    def __init__(self, timeline: MonotonicTime) -> None:
        self._timeline = timeline
        self._last: Status | None = None
        self._bad_since_s: float | None = None
        self._faulty_s: dict[str, float] = {}
        """Time of the last fault of each field (s, the solver's own time)."""
        self.fault: str | None = None
        self.bad_s = 0.0

    def follow(self, status: Status) -> Status | None:
        """Return the status in the solver's own time.

        For an unusable status, return the last usable one with the present time, estimated if the status has none.
        None if there was no usable status.
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
        """Return True if this tick's fault is new or was not reported recently. Call once per tick with a fault."""
        assert self.fault is not None
        field, now = self.fault.split(" ")[0], self._timeline.now_s or 0.0
        last_s = self._faulty_s.get(field)
        self._faulty_s[field] = now
        return last_s is None or now - last_s > TELL_AGAIN_S
