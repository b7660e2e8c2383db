"""Grades the continuation of an exact drive after a standstill, and ranks the grades."""

from __future__ import annotations

from stucksolver.scene.base_model import FrozenModel
from stucksolver_eval.metrics.recovery import AFTER_S, PROGRESS_M, WITHIN_S
from stucksolver_eval.metrics.right_reaction import NOT_HARM
from stucksolver_eval.metrics.smoothness import CORRECTED, smoothness
from stucksolver_eval.results.checkpoint import TICK_S, RouteRecord
from stucksolver_eval.results.metric_info import Array
from stucksolver_eval.results.outcome import RouteOutcome

COLLISION = "collisions_"
"""Prefix of the infraction kinds that are collisions."""


class Grade(FrozenModel):
    """The outcome of one drive from the standstill on.

    Attributes:
        recovered_after_s: Time until 15 m of new progress (s); None if the vehicle did not get that far.
        collisions: Collisions until 10 s after the recovery, or until the end if there was none.
        infractions: Other infractions in the same time, except those about time and speed.
        near_misses: Near misses in the same time.
        comfort: Share of one-second blocks within nuPlan's bounds (the corrected rule); None if the drive is too short.
        driving_score: The route's driving score, 0 to 100.
        completion: Route completion (%).
        success: The route was driven to its end without an infraction.
        state: State at the end of the drive, in the leaderboard's words.
    """

    recovered_after_s: float | None
    collisions: int
    infractions: int
    near_misses: int
    comfort: float | None
    driving_score: float
    completion: float
    success: bool
    state: str

    @property
    def recovers(self) -> bool:
        """True for 15 m of progress within 60 s without harm: the evaluation's definition of a recovery."""
        in_time = self.recovered_after_s is not None and self.recovered_after_s <= WITHIN_S
        return in_time and self.collisions + self.infractions == 0

    @property
    def rank(self) -> tuple[float, ...]:
        """Rank of the grade; larger is better.

        The order is: no harm, recovery, near misses, score, time, comfort. It is lexicographic, so no weight has to be
        chosen. Harm comes first because no other value makes up for it.
        """
        late_s = WITHIN_S * 10 if self.recovered_after_s is None else self.recovered_after_s
        harm = -float(self.collisions), -float(self.infractions)
        return *harm, float(self.recovers), -float(self.near_misses), self.driving_score, -late_s, self.comfort or 0.0


def grade(outcome: RouteOutcome, record: RouteRecord, motion: dict[str, Array], at_s: float) -> Grade:
    """Grade a drive from the time `at_s` on (s since the start of the route).

    Args:
        outcome: The events of the drive.
        record: The scores.
        motion: The ego's motion, each array of shape (ticks, 3), as `read_metric_info` returns it.
        at_s: Time of the standstill (s).
    """
    place_m = max((place for t, place in outcome.track if t <= at_s), default=0.0)
    arrived = [t for t, place in outcome.track if t > at_s and place >= place_m + PROGRESS_M]
    until_s = arrived[0] + AFTER_S if arrived else float("inf")
    noted = [i.kind for i in outcome.infractions if at_s <= i.time_s <= until_s and i.kind not in NOT_HARM]
    later = {name: values[round(at_s / TICK_S) :] for name, values in motion.items()}
    return Grade(
        recovered_after_s=round(arrived[0] - at_s, 2) if arrived else None,
        collisions=sum(kind.startswith(COLLISION) for kind in noted),
        infractions=sum(not kind.startswith(COLLISION) for kind in noted),
        near_misses=sum(at_s <= miss.time_s <= until_s for miss in outcome.near_misses),
        comfort=round(smoothness(later, CORRECTED), 4) if len(later["acceleration"]) >= 3 else None,
        driving_score=record.scores.score_composed,
        completion=record.scores.score_route,
        success=record.success,
        state=record.status,
    )
