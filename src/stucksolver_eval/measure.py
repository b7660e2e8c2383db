"""What is measured while a run goes on: completion, standing still, recovery."""

from __future__ import annotations

from dataclasses import dataclass, field

from stucksolver.detect import Detector, Trigger
from stucksolver.scene import Status
from stucksolver.solver import ProgressWatch

STANDING_MPS = 0.1
BLOCKED_S = 60.0


@dataclass
class Measures:
    """Figures of one run, updated tick by tick from the stack's own status."""

    length_m: float
    start_m: float
    detector: Detector = field(default_factory=Detector)
    standing_s: float = 0.0
    standing_run_s: float = 0.0
    stuck: list[tuple[float, float]] = field(default_factory=list)
    watch: ProgressWatch = field(default_factory=ProgressWatch)
    immobilizations: int = 0
    recovery_times_s: list[float] = field(default_factory=list)
    _last: Status | None = None

    def update(self, status: Status) -> None:
        """Take one tick's status."""
        dt = 0.0 if self._last is None else status.time_s - self._last.time_s
        self._last = status
        if status.speed_mps < STANDING_MPS:
            self.standing_s += dt
            self.standing_run_s += dt
        else:
            self.standing_run_s = 0.0
        trigger = self.detector.update(status)
        self._span(status, trigger, dt)
        self._recovery(status, trigger)

    def _span(self, status: Status, trigger: Trigger | None, dt: float) -> None:
        if trigger is None:
            return
        if self.stuck and status.time_s - self.stuck[-1][1] <= dt + 1e-6:
            self.stuck[-1] = (self.stuck[-1][0], status.time_s)
        else:
            since = self.detector.slow_since_s
            self.stuck.append((status.time_s if since is None else since, status.time_s))

    def _recovery(self, status: Status, trigger: Trigger | None) -> None:
        was_on = self.watch.on
        self.watch, recovered_after_s = self.watch.updated(status, self.detector.slow_since_s, trigger)
        self.immobilizations += self.watch.on and not was_on
        if recovered_after_s is not None:
            self.recovery_times_s.append(recovered_after_s)

    @property
    def completion_pct(self) -> float:
        if self._last is None:
            return 0.0
        done = (self._last.progress_m - self.start_m) / max(self.length_m, 1e-6)
        return 100.0 if self._last.at_destination else round(min(max(100 * done, 0.0), 100.0), 2)
