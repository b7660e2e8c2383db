"""Assesses whole plans for a reasoner: each step by the guard, from where the steps before it end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stucksolver.guard import NOBODY, RULES, Approvals, Guard, ProvenPlan, RejectCode, RejectReason, Verdict
from stucksolver.guard.path_checks import least_stationary_gap
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.assessment import MOST_FREE_M, PlanAssessment, Shortfall
from stucksolver.plan.behaviors import REGISTRY, drives_legs
from stucksolver.plan.frenet_path import STEP_M, FrenetPath
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.relocated_ego import RelocatedEgo
from stucksolver.scene.road import LaneDirection
from stucksolver.solver.state_machine.approval_rules import ASKABLE, RED_LIGHT, approvable_rules, check_authorized
from stucksolver.solver.state_machine.history import NEAR, PASSING, moving
from stucksolver.solver.state_machine.path_points import facing
from stucksolver.solver.state_machine.segments import Segment, segments_of

STATIC = frozenset(
    {RejectCode.COLLISION, RejectCode.GAP, RejectCode.NO_PATH, RejectCode.OFF_LANES, RejectCode.LEAVES_LANE}
)
"""Reasons that depend only on what is stationary, so that they are known before the plan begins."""
BESIDE_M = 0.2
"""Lateral margin of the ego's path (m), as in `FrenetScene.in_corridor`."""
EVERY_APPROVAL = Approvals(operator=frozenset((*REGISTRY, *RULES)))
"""What people could approve at most: a plan that lacks only an approval is checked for everything else with it."""


@dataclass(frozen=True)
class _Reached:
    """Where a part of a plan ends: the surroundings from there, and the assessment up to there."""

    view: FrenetScene
    so_far: PlanAssessment


class PlanPreview:
    """Assesses plans in one tick's surroundings. Common beginnings of plans are checked once.

    Args:
        guard: Guard that checks the steps.
        view: Surroundings in road coordinates.
        guided: Returns True for a plan that the passenger's guidance requests.
        approvals: Approvals by people.
    """

    def __init__(
        self,
        guard: Guard,
        view: FrenetScene,
        guided: Callable[[RecoveryPlan], bool],
        approvals: Approvals = NOBODY,
    ) -> None:
        self._guard = guard
        self._view = view
        self._guided = guided
        self._approvals = approvals
        self._moving = moving(view)
        self._reached: dict[tuple[bool, tuple[Segment, ...], bool], _Reached] = {}
        self.checks = 0
        """Number of steps that the guard has checked."""

    @cached_property
    def _elsewhere(self) -> RelocatedEgo:
        return RelocatedEgo(self._view)

    def assess(self, plan: RecoveryPlan) -> PlanAssessment:
        """Return the assessment of a whole plan."""
        barred = check_authorized(plan, self._guard, self._approvals)
        guided = self._guided(plan)
        segments = segments_of(plan.behaviors)
        reached, begins, step = _Reached(self._view, PlanAssessment()), 0, None
        for count in range(1, len(segments) + 1):
            last = count == len(segments)
            key = (guided, segments[:count], last)
            known = self._reached.get(key)
            if known is None:
                known = self._reached[key] = self._after(reached, segments[count - 1], guided, last, count == 1)
            reached = known
            if step is None and reached.so_far.shortfalls:
                step = begins
            if any(not item.passing for item in reached.so_far.shortfalls):
                break
            begins += len(segments[count - 1])
        result = reached.so_far.model_copy(update={"step": step})
        if RED_LIGHT[0] not in approvable_rules(plan):
            result = result.model_copy(update={"shortfalls": tuple(map(_not_over_red, result.shortfalls))})
        if barred is not None and all(item.passing or item.approval for item in result.shortfalls):
            lacking = (*result.shortfalls, *self._shortfalls(barred, frozenset()))
            result = result.model_copy(update={"step": step or 0, "shortfalls": lacking})
        return result

    def later_refusal(self, plan: RecoveryPlan) -> Verdict | None:
        """Return a rejection if a later step has no room where it will begin; None if that is not known.

        Traffic and sight distances at that time are not known now. They are checked when the step begins.
        """
        if len(segments_of(plan.behaviors)) < 2:
            return None
        found = self.assess(plan)
        known = tuple(item for item in found.shortfalls if item.code in STATIC and not (item.passing or item.approval))
        if not found.step or not known:
            return None
        name = plan.behaviors[found.step].name
        return Verdict(
            rejects=tuple(
                RejectReason(
                    code=item.code,
                    detail=f"later, {name}: {item.detail}",
                    object_id=item.object_id,
                    failure=item.failure,
                    margin=None if item.missing is None else -item.missing,
                    unit=item.unit,
                )
                for item in known
            )
        )

    def _after(self, before: _Reached, segment: Segment, guided: bool, last: bool, now: bool) -> _Reached:
        """Return what is reached after one more step. `now`: it is the first step, in the present surroundings."""
        self.checks += 1
        first, view = segment[0], before.view
        if first.stands_still:
            verdict = self._guard.allows_standing(first, view, self._approvals)
            waited = before.so_far.model_copy(
                update={"duration_s": before.so_far.duration_s + first.time_allowance_s(0.0)}
            )
            return _Reached(view, self._with(waited, verdict, now))
        if drives_legs(first):
            verdict, leg = self._guard.accept_turn(first, view, self._approvals)
            took = 0.0 if leg is None else leg.expected_s + leg.after_s
            turned = before.so_far.model_copy(update={"duration_s": before.so_far.duration_s + took})
            return _Reached(view, self._with(turned, verdict, now))
        verdict, proven = self._guard.accept(segment, view, guided, self._approvals, not last)
        so_far = self._with(before.so_far, verdict, now)
        if proven is None and all(item.passing or item.approval for item in so_far.shortfalls):
            quiet = self._elsewhere.without_traffic() if now else view
            static, proven = self._guard.accept(segment, quiet, guided, EVERY_APPROVAL, not last)
            so_far = so_far if static.accepted else self._with(before.so_far, static, now)
        if proven is None:
            return _Reached(view, so_far)
        if verdict.sight is not None:
            spare_m = verdict.sight.seen_m - verdict.sight.needed_m
            so_far = so_far.model_copy(update={"sight_margin_m": _least(so_far.sight_margin_m, spare_m)})
        return self._moved_on(before, so_far, proven, last)

    def _moved_on(self, before: _Reached, so_far: PlanAssessment, proven: ProvenPlan, last: bool) -> _Reached:
        """Return what is reached at the end of a proven path. After the last step no further view is needed."""
        view, path, sign = before.view, proven.path, -1.0 if proven.reverse else 1.0
        turned = facing(view, proven)
        gap_m, gap_margin_m = least_stationary_gap(proven.context(turned, path, self._guard.policy))
        way_m, end_s, end_d = float(path.end_s - path.s[0]), sign * path.end_s, sign * path.end_d
        duration_s = so_far.duration_s + proven.expected_s
        reached = so_far.model_copy(
            update={
                "duration_s": duration_s,
                "way_m": so_far.way_m + way_m,
                "back_m": so_far.back_m + (way_m if proven.reverse else 0.0),
                "progress_m": so_far.progress_m + sign * way_m,
                "offset_m": end_d,
                "free_m": _free_m(view, end_s, end_d),
                "passed": _passed(self._view, end_s, duration_s),
                "leaves_zone": self._view.zone_at(self._view.ego_s) is not None and self._view.zone_at(end_s) is None,
                "gap_m": _least(so_far.gap_m, gap_m),
                "gap_margin_m": _least(so_far.gap_margin_m, gap_margin_m),
                "oncoming_m": so_far.oncoming_m + _oncoming_m(path, turned),
            }
        )
        if last:
            return _Reached(view, reached)
        yaw = float(path.body(turned.ego_yaw, view.ego.limits.wheelbase_m)[-1])
        return _Reached(self._elsewhere.at(end_s, end_d, yaw, duration_s), reached)

    def _with(self, so_far: PlanAssessment, verdict: Verdict, now: bool) -> PlanAssessment:
        """Return the assessment with one more verdict. Traffic counts as passing only in the present surroundings."""
        if verdict.accepted:
            return so_far
        lacking = (*so_far.shortfalls, *self._shortfalls(verdict, self._moving if now else frozenset()))
        return so_far.model_copy(update={"shortfalls": lacking})

    @staticmethod
    def _shortfalls(verdict: Verdict, moving_ids: frozenset[str]) -> tuple[Shortfall, ...]:
        return tuple(_shortfall(reject, moving_ids) for reject in verdict.rejects)


def _least(first: float | None, second: float | None) -> float | None:
    """Return the smaller number; None counts as unknown, not as small."""
    return second if first is None else first if second is None else min(first, second)


def _not_over_red(item: Shortfall) -> Shortfall:
    """Return the shortfall as one that no approval removes, if it is a red light."""
    return item.model_copy(update={"approval": False}) if item.code is RejectCode.RED_LIGHT else item


def _shortfall(reject: RejectReason, moving_ids: frozenset[str]) -> Shortfall:
    traffic = reject.code in PASSING - {RejectCode.RED_LIGHT, RejectCode.STALE}
    return Shortfall(
        code=reject.code,
        detail=reject.detail,
        object_id=reject.object_id,
        failure=reject.failure,
        missing=reject.missing,
        unit=reject.unit,
        passing=traffic or (reject.code in NEAR and reject.object_id in moving_ids),
        approval=reject.code in ASKABLE,
    )


def _passed(view: FrenetScene, s_m: float, after_s: float) -> tuple[str, ...]:
    """Return the ids of the objects ahead of the ego that an ego at an arc length (m) has passed after a time (s)."""
    there = view.s + np.maximum(view.vs, 0.0) * after_s
    which = (view.s > view.ego_s) & (there + view.along < s_m - view.ego.length_m / 2)
    return tuple(view.objects[int(i)].id for i in np.flatnonzero(which))


def _free_m(view: FrenetScene, s_m: float, d_m: float) -> float:
    """Return the free distance ahead of an ego there, at that lateral offset (m)."""
    half_width, half_length = view.ego.width_m / 2 + BESIDE_M, view.ego.length_m / 2
    beside = ~view.moving & (np.abs(view.d - d_m) - view.across < half_width) & (view.s > s_m)
    gaps = view.s[beside] - view.along[beside] - s_m - half_length
    return float(min(gaps.min(initial=MOST_FREE_M), MOST_FREE_M))


def _oncoming_m(path: FrenetPath, view: FrenetScene) -> float:
    """Return the length of a path on which the body is in a lane of oncoming traffic (m)."""
    half, inside = view.ego.width_m / 2, np.zeros(len(path.s), dtype=bool)
    for lane in path.enters:
        if lane.strip.direction is LaneDirection.OPPOSITE:
            right, left = np.interp(path.s, lane.s, lane.right), np.interp(path.s, lane.s, lane.left)
            inside |= (path.d + half > right) & (path.d - half < left)
    return float(inside.sum()) * STEP_M
