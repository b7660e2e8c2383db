"""The guard: proves a plan before it starts, and again on every tick while it runs. It reads surroundings only."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stucksolver.decision.behaviors import Abort, Behavior, CannotPlan, Check, Start
from stucksolver.decision.manoeuvre import Manoeuvre, lateral, shortest_shift
from stucksolver.guard import checks, traffic
from stucksolver.guard.case import Case
from stucksolver.guard.policy import NOBODY, Approvals, GuardPolicy
from stucksolver.guard.verdict import OK, Reject, RejectCode, Verdict
from stucksolver.scene.road import LaneDirection
from stucksolver.scene.view import View

CHECKS: dict[Check, Callable[[Case], list[Reject]]] = {
    Check.COLLISION: checks.collision,
    Check.DRIVABLE_AREA: checks.drivable_area,
    Check.SPEED: checks.speed,
    Check.STOP_LINE: checks.stop_line,
    Check.MARKING: checks.marking,
    Check.ONCOMING: traffic.oncoming,
    Check.LANE_ENTRY: traffic.lane_entry,
}


@dataclass(frozen=True)
class Proven:
    """Behaviours that the guard has accepted as one path.

    `ends_s`: where each behaviour ends. `commit_s`: from there on the ego can no longer stop inside its own lane, so
    that finishing, which was proven, is the safe way out; None for a path that never leaves the lane.
    """

    behaviors: tuple[Behavior, ...]
    path: Manoeuvre
    ends_s: tuple[float, ...]
    commit_s: float | None
    expected_s: float
    guided: bool
    approvals: Approvals = NOBODY

    @property
    def checks(self) -> tuple[Check, ...]:
        return tuple(check for check in CHECKS if any(check in b.checks for b in self.behaviors))

    def committed(self, s: float) -> bool:
        return self.commit_s is not None and s >= self.commit_s


class Guard:
    """Accepts, refuses and aborts. Its policy is fixed when it is made."""

    def __init__(self, policy: GuardPolicy | None = None) -> None:
        self.policy = policy or GuardPolicy()

    def accept(
        self, behaviors: Sequence[Behavior], view: View, guided: bool, approvals: Approvals = NOBODY
    ) -> tuple[Verdict, Proven | None]:
        """Judge behaviours that move, as one path from here. The second value is None when refused."""
        first = [r for r in (self._stale(view), *(self._unreleased(b, approvals) for b in behaviors)) if r]
        if first:
            return Verdict(rejects=tuple(first)), None
        try:
            proven = self._plan(behaviors, view, guided, approvals)
        except CannotPlan as error:
            return Verdict(rejects=(Reject(code=RejectCode.NO_PATH, detail=str(error)),)), None
        rejects = self._run(proven.checks, Case(view, proven.path, self.policy, guided, approvals=approvals))
        return (Verdict(rejects=tuple(rejects)), None) if rejects else (OK, proven)

    def allows_standing(self, behavior: Behavior, view: View, approvals: Approvals = NOBODY) -> Verdict:
        """Judge a behaviour that stands still."""
        old = self._stale(view) or self._unreleased(behavior, approvals)
        why = behavior.precondition(view)
        if old:
            return Verdict(rejects=(old,))
        return Verdict(rejects=(Reject(code=RejectCode.PRECONDITION, detail=why),)) if why else OK

    def recheck(self, proven: Proven, view: View) -> Verdict:
        """Judge a running plan on this tick; a verdict with reasons names the abort."""
        off = self._off_path(proven, view)
        rest = proven.path.from_station(view.ego_s)
        case = Case(view, rest, self.policy, proven.guided, running=True, approvals=proven.approvals)
        if not proven.committed(view.ego_s):
            known = [reject for reject in (self._stale(view), off) if reject]
            rejects = known or self._run(proven.checks, case)
            return Verdict(rejects=tuple(rejects), abort=self._before_commit(view)) if rejects else OK
        if not case.in_oncoming_lane:
            red = checks.stop_line(case)
            if red:
                return Verdict(rejects=tuple(red), abort=Abort.STOP)
        rejects = ([off] if off else []) + checks.collision(case)
        if not rejects:
            return OK
        wanted = {b.abort_after_commit for b in proven.behaviors}
        way = Abort.FINISH
        if Abort.RETURN_TO_LANE in wanted and self.way_back(view) is not None:
            way = Abort.RETURN_TO_LANE
        return Verdict(rejects=tuple(rejects), abort=way)

    def _before_commit(self, view: View) -> Abort:
        """A stop, unless the stack has strayed into an oncoming lane, where a stop is never the way out."""
        lane = view.ego_lane
        if lane is None or lane.strip.direction is not LaneDirection.OPPOSITE:
            return Abort.STOP
        return Abort.FINISH if self.way_back(view) is None else Abort.RETURN_TO_LANE

    def way_back(self, view: View) -> Manoeuvre | None:
        """A path without collision, on the road, from here back into the route's own lane, None where there is none."""
        speed = max(view.ego.speed_mps, 3.0)
        length = max(2.0 * speed, shortest_shift(view.ego_d, view.ego.limits.min_turn_radius_m), 4.0)
        path = lateral(view.ego_s, view.ego_d, 0.0, length, speed, view)
        case = Case(view, path, self.policy)
        return None if checks.collision(case) or checks.drivable_area(case) else path

    def _plan(self, behaviors: Sequence[Behavior], view: View, guided: bool, approvals: Approvals) -> Proven:
        start = Start(view.ego_s, view.ego_d, view.ego.speed_mps)
        path: Manoeuvre | None = None
        ends: list[float] = []
        for k, behavior in enumerate(behaviors):
            why = behavior.precondition(view) if k == 0 else None
            part = None if why else behavior.manoeuvre(view, start)
            if part is None:
                raise CannotPlan(why or f"{behavior.name} has no path")
            path = part if path is None else path.then(part)
            ends.append(part.end_s)
            start = Start(part.end_s, part.end_d, float(part.speed[-1]))
        if path is None:
            raise CannotPlan("the plan is empty")
        case = Case(view, path, self.policy, guided)
        expected = case.slow.duration_s
        return Proven(tuple(behaviors), path, tuple(ends), _commit(case), expected, guided, approvals)

    def _run(self, names: tuple[Check, ...], case: Case) -> list[Reject]:
        return [reject for name in names for reject in CHECKS[name](case)]

    def _unreleased(self, behavior: Behavior, approvals: Approvals) -> Reject | None:
        needed = self.policy.release(behavior.name)
        if approvals.cover(behavior.name, needed):
            return None
        return Reject(code=RejectCode.APPROVAL, detail=f"{behavior.name} needs the yes of the {needed.value}")

    def _stale(self, view: View) -> Reject | None:
        age = view.surroundings.age_s
        if age <= self.policy.max_age_s:
            return None
        return Reject(code=RejectCode.STALE, detail=f"the surroundings are {age:.1f} s old")

    def _off_path(self, proven: Proven, view: View) -> Reject | None:
        error = abs(view.ego_d - float(np.interp(view.ego_s, proven.path.s, proven.path.d)))
        if error <= self.policy.tracking_error_m:
            return None
        return Reject(code=RejectCode.DEVIATION, detail=f"{error:.1f} m beside the proven path", gap_m=error)


def _commit(case: Case) -> float | None:
    """Where the ego can for the last time stop inside its own lane, by comfortable braking."""
    leaves = [np.flatnonzero(case.inside(lane)) for lane in case.path.enters if lane is not case.start_lane]
    first = min((int(k[0]) for k in leaves if len(k)), default=None)
    if first is None:
        return None
    braking = case.view.ego.limits.comfort_braking_mps2
    room = case.path.s[first] - case.path.s[: first + 1]
    can_stop = case.quick.v[: first + 1] ** 2 / (2 * braking) <= room
    last = np.flatnonzero(can_stop)
    return float(case.path.s[last[-1]]) if len(last) else float(case.path.s[0])
