"""Detects immobilization from speed, route progress and contact. Runs on every tick, so it is cheap."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import Enum

from stucksolver.scene.scene import EXPECTED_PROGRESS_M, IMMOBILIZED_BELOW_MPS
from stucksolver.scene.status import Status


class Trigger(str, Enum):
    """Reason for which the solver is triggered."""

    SPEED = "speed"
    PROGRESS = "progress"
    CONTACT = "contact"
    GUIDANCE = "guidance"


@dataclass(frozen=True)
class DetectorSettings:
    """Thresholds of an immobilization. Defaults: below 5 km/h for 1 s, or less than 5 m in 20 s (Bao and Li 2025).

    Attributes:
        v_min_mps: Speed below which the vehicle counts as slow (m/s).
        dwell_s: Time for which the vehicle must be slow (s).
        progress_m: New progress along the route expected within the window (m).
        progress_window_s: Length of that window (s).

    Raises:
        ValueError: A setting is not greater than 0.
    """

    v_min_mps: float = IMMOBILIZED_BELOW_MPS
    dwell_s: float = 1.0
    progress_m: float = EXPECTED_PROGRESS_M
    progress_window_s: float = 20.0

    def __post_init__(self) -> None:
        for name in ("v_min_mps", "dwell_s", "progress_m", "progress_window_s"):
            if not getattr(self, name) > 0:
                raise ValueError(f"detector setting {name} must be greater than 0, not {getattr(self, name)}")


class Detector:
    """Detector of an immobilization, updated with one status per tick."""

    def __init__(self, settings: DetectorSettings | None = None) -> None:
        self.settings = settings or DetectorSettings()
        self.slow_since_s: float | None = None
        """Time when the vehicle became slow (s); None while at speed. Pushing an object along counts as slow."""
        self._marks: deque[tuple[float, float]] = deque()

    def update(self, status: Status) -> Trigger | None:
        """Return the trigger at this tick; None without one, or at the destination."""
        if status.at_destination:
            self.forget()
            return None
        now = status.time_s
        self._mark(now, status.progress_m)
        if status.speed_mps >= self.settings.v_min_mps and not status.pushes:
            self._at_speed(now)
        elif self.slow_since_s is None:
            self.slow_since_s = now
        if self.slow_since_s is not None and now - self.slow_since_s >= self.settings.dwell_s - 1e-9:
            return Trigger.CONTACT if status.pushes else Trigger.SPEED
        progress = self.progress_in_window_m
        if progress is not None and progress < self.settings.progress_m:
            return Trigger.PROGRESS
        return None

    @property
    def progress_in_window_m(self) -> float | None:
        """New progress along the route within the last window (m); None before the first full window."""
        if not self._marks:
            return None
        (first_s, first_m), (last_s, last_m) = self._marks[0], self._marks[-1]
        return last_m - first_m if last_s - first_s >= self.settings.progress_window_s - 0.5 else None

    def forget(self) -> None:
        """Reset the detector: motion before the end of a plan says nothing about motion after it."""
        self.slow_since_s = None
        self._marks.clear()

    def _at_speed(self, now_s: float) -> None:
        """Note that the vehicle is at speed. After a reported standstill, the progress window restarts."""
        if self.slow_since_s is not None and now_s - self.slow_since_s >= self.settings.dwell_s:
            self._marks.clear()
        self.slow_since_s = None

    def _mark(self, now_s: float, progress_m: float) -> None:
        """Store one mark every half second, which is enough for a window of many seconds."""
        marks = self._marks
        if marks and now_s - marks[-1][0] < 0.5:
            return
        marks.append((now_s, progress_m))
        while now_s - marks[0][0] > self.settings.progress_window_s:
            marks.popleft()
