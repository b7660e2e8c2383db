"""The vehicle is stopped for too long (ActorBlockedTest)."""

from __future__ import annotations

from stucksolver_eval.criteria.criterion import STANDING_MPS, Criterion, EgoTick, place_text

LIMIT_S = 60.0
"""Longest stop (s). As in Bench2Drive."""
FAILURE = "Agent got blocked"


class Blocked(Criterion):
    """Fails after 60 s below 0.1 m/s. The time does not run during a suspension, and restarts after it."""

    kind = "vehicle_blocked"

    def __init__(self) -> None:
        super().__init__()
        self._moved_s: float | None = None

    def update(self, moment: EgoTick) -> None:
        moving = moment.speed_mps >= STANDING_MPS
        if self._moved_s is None or moving or "blocked" in moment.suspended:
            self._moved_s = moment.time_s
        elif moment.time_s - self._moved_s > LIMIT_S and self.ends_route is None:
            self.ends_route = FAILURE
            self.note(moment.time_s, f"blocked at {place_text(moment.location)}")
