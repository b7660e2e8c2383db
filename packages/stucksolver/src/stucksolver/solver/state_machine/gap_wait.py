"""Decides how long a running plan waits before it is given up and a new one is made."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from stucksolver.guard import RejectCode, Verdict
from stucksolver.guard.lane_entry import GivingWay
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.surroundings import EgoState
from stucksolver.solver.state_machine.history import moving, waits_for_nothing

SENSED_WAIT_S, GETS_ON_M = 15.0, 1.0
"""By sensors, a plan that stands for a gap this long without getting on by so much ends: its path goes round what was
seen when it began. The next one begins from there and goes round what is seen by then.
"""
STAYS_WAIT_S = 3.0
"""A plan that waits for stationary objects only is given up after this time (s): they do not let it by. Ours: a person
who has just stopped mostly walks on within this time.
"""
SIGHT_COMES_S = 3.0
"""From a new place, or past a car that has gone by, the camera counts with three looks, half a second apart; and the
track of who has gone by must have ended (s).
"""
STOPPED_MPS = 0.15
"""A slower vehicle stands."""


@dataclass(frozen=True)
class GapWait:
    """Where a plan began to give way, x, y (m), and when (s)."""

    x_m: float
    y_m: float
    since_s: float
    in_vain_s: float | None = None
    """Since when it waits for nothing that moves (s); None while something does."""

    @staticmethod
    def after(before: GapWait | None, verdict: Verdict, view: FrenetScene, now_s: float) -> GapWait:
        """Return the same wait after one more tick, or a new one if the ego has got on since."""
        ego, in_vain_s = view.ego, None if before is None else before.in_vain_s
        if not waits_for_nothing(verdict, moving(view)):
            in_vain_s = None
        elif in_vain_s is None:
            in_vain_s = now_s
        if before is None or math.hypot(ego.x_m - before.x_m, ego.y_m - before.y_m) > GETS_ON_M:
            return GapWait(ego.x_m, ego.y_m, now_s, in_vain_s)
        return replace(before, in_vain_s=in_vain_s)

    def has_timed_out(self, ego: EgoState, now_s: float) -> bool:
        """True if the ego has stood too long: with sensors by time alone, else only for what does not move.

        What sensors report of an object wavers, so that a stationary object may be traffic there.
        """
        if abs(ego.speed_mps) > STOPPED_MPS:
            return False
        if ego.position_sd_m is not None:
            return now_s - self.since_s > SENSED_WAIT_S
        return self.in_vain_s is not None and now_s - self.in_vain_s > STAYS_WAIT_S


def sight_may_improve(verdict: Verdict, ego: EgoState, waited_s: float) -> bool:
    """True if only the sight of the oncoming lane lacks, and sensors have not had the time for it (s) yet."""
    lacks = set(verdict.codes) == {RejectCode.ONCOMING_SIGHT}
    return ego.position_sd_m is not None and lacks and waited_s < SIGHT_COMES_S


def yield_targets(verdict: Verdict, ego: EgoState, before: GivingWay) -> GivingWay:
    """Return to whom the ego gives way: those whom a verdict names, or everybody if it names nobody.

    What sensors see of a vehicle wavers: by them, one that was named `before` still has to be let by.
    """
    named = frozenset(r.object_id for r in verdict.rejects if r.object_id is not None)
    kept = before if ego.position_sd_m is not None and isinstance(before, frozenset) else frozenset()
    return named | kept or True
