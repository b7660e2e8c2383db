"""Carries an accepted plan through, behaviour by behaviour, with the guard looking on at every tick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver.decision import Execute, PathPoint, RecoveryPlan
from stucksolver.decision.behaviors import Abort, Behavior, KeepLane, Wait
from stucksolver.decision.manoeuvre import Manoeuvre, landing_m
from stucksolver.guard import NOBODY, Approvals, Guard, Proven, Reject, RejectCode, Verdict
from stucksolver.scene.view import View

ARRIVED_M = 1.5
"""A behaviour counts as driven this far before its end, a whole path as far as `landing_m` says."""
STOPPED_MPS = 0.15
BACK_IN_LANE_M = 0.4


@dataclass(frozen=True)
class Outcome:
    """How a plan ended."""

    finished: bool
    text: str


class Execution:
    """One plan on its way. Call `start`, then `tick` until it returns an `Outcome`."""

    def __init__(self, plan: RecoveryPlan, guard: Guard, guided: bool, approvals: Approvals = NOBODY) -> None:
        self.plan = plan
        self._guard = guard
        self._guided = guided
        self._approvals = approvals
        self._segments = _segments(plan.behaviors)
        self._proven: Proven | None = None
        self._directive: Execute | None = None
        self._until_s = 0.0
        self._index = 0
        self._withdrawn = False
        self._ending: Outcome | None = None
        self._way_back: Manoeuvre | None = None
        self.last_verdict = Verdict()

    def start(self, view: View, now_s: float) -> Verdict:
        """Have the guard prove the next stretch; begins it when it is accepted."""
        segment = self._segments[0]
        if segment[0].stands_still:
            verdict = self._guard.allows_standing(segment[0], view, self._approvals)
            expected = 0.0
        else:
            verdict, self._proven = self._guard.accept(segment, view, self._guided, self._approvals)
            expected = self._proven.expected_s if self._proven else 0.0
        if verdict.accepted:
            self._segments.pop(0)
            self._index = 0
            self._until_s = now_s + max(b.time_allowance_s(expected) for b in segment)
            self._directive = self._execute(segment[0], view)
        return verdict

    def withdraw(self) -> None:
        """Give the plan up as soon as that is safe: at once before the commit point, else at its end."""
        self._withdrawn = True

    def tick(self, view: View, now_s: float) -> Execute | Outcome:
        """What to do at this tick, or how it ended."""
        if self._ending is not None:
            return self._end(view)
        if self._withdrawn and (self._proven is None or not self._proven.committed(view.ego_s)):
            return self._abort(Abort.STOP, "withdrawn", view)
        if self._proven is None:
            return self._stand(view, now_s)
        return self._move(self._proven, view, now_s)

    def _stand(self, view: View, now_s: float) -> Execute | Outcome:
        assert self._directive is not None
        behavior = self._directive.behavior
        if isinstance(behavior, Wait) and now_s < self._until_s - 1.0:
            return self._directive
        return self._next(view, now_s)

    def _move(self, proven: Proven, view: View, now_s: float) -> Execute | Outcome:
        self.last_verdict = verdict = self._guard.recheck(proven, view)
        if not verdict.accepted and verdict.abort is not Abort.FINISH:
            return self._abort(verdict.abort or Abort.STOP, str(verdict), view)
        if now_s > self._until_s and not proven.committed(view.ego_s):
            late = Reject(code=RejectCode.TIMEOUT, detail="it took longer than its time allowance")
            self.last_verdict = Verdict(rejects=(late,), abort=Abort.STOP)
            return self._abort(Abort.STOP, str(self.last_verdict), view)
        if view.ego_s >= proven.path.end_s - landing_m(view.ego.speed_mps):
            self._proven = None
            return self._next(view, now_s)
        while self._index < len(proven.ends_s) - 1 and view.ego_s >= proven.ends_s[self._index] - ARRIVED_M:
            self._index += 1
            self._directive = self._execute(proven.behaviors[self._index], view)
        assert self._directive is not None
        return self._directive

    def _next(self, view: View, now_s: float) -> Execute | Outcome:
        if not self._segments:
            return Outcome(True, "the plan is done")
        verdict = self.start(view, now_s)
        if not verdict.accepted:
            return self._abort(Abort.STOP, f"the next step was refused: {verdict}", view)
        assert self._directive is not None
        return self._directive

    def _abort(self, way: Abort, why: str, view: View) -> Execute | Outcome:
        self._ending = Outcome(False, why)
        if way is Abort.RETURN_TO_LANE:
            self._way_back = self._guard.way_back(view)
        if self._way_back is None:
            self._directive = Execute(behavior=Wait(duration_s=2.0))
        else:
            distance = min(max(self._way_back.end_s - view.ego_s, 5.0), 150.0)
            behavior = KeepLane(distance_m=distance, speed_mps=min(max(view.ego.speed_mps, 3.0), 11.0))
            self._directive = Execute(behavior=behavior, path=path_points(self._way_back, view))
        return self._end(view)

    def _end(self, view: View) -> Execute | Outcome:
        """Until the abort has brought the ego to rest, or back into its lane."""
        assert self._ending is not None and self._directive is not None
        if self._way_back is None:
            done = view.ego.speed_mps < STOPPED_MPS
        else:
            done = abs(view.ego_d) < BACK_IN_LANE_M or view.ego_s >= self._way_back.end_s - landing_m(
                view.ego.speed_mps
            )
        return self._ending if done else self._directive

    def _execute(self, behavior: Behavior, view: View) -> Execute:
        path = path_points(self._proven.path.from_station(view.ego_s), view) if self._proven else ()
        return Execute(behavior=behavior, path=path)  # type: ignore[arg-type]


def _segments(behaviors: tuple[Behavior, ...]) -> list[list[Behavior]]:
    """Behaviours that move are proven together, as one path; each that stands still is by itself."""
    segments: list[list[Behavior]] = []
    for behavior in behaviors:
        if behavior.stands_still or not segments or segments[-1][0].stands_still:
            segments.append([behavior])
        else:
            segments[-1].append(behavior)
    return segments


def path_points(path: Manoeuvre, view: View) -> tuple[PathPoint, ...]:
    """A path in the local frame."""
    x, y, _ = view.frame.to_local(path.s, path.d)
    rows = np.stack([x, y, path.speed], axis=1).round(3).tolist()
    return tuple(PathPoint(x_m=a, y_m=b, speed_mps=v) for a, b, v in rows)
