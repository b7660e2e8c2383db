"""Proves a plan before it starts, and again on every tick while it runs. The guard reads only surroundings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stucksolver.guard import back_up, lane_entry, oncoming_lane, path_checks, speed_caps, traffic_rules
from stucksolver.guard.abort_stops import are_stops_safe, commit_mask, is_junction_stop_clear, stops_beside
from stucksolver.guard.adjacent_traffic import from_behind
from stucksolver.guard.blind_stop import stopping_soon
from stucksolver.guard.collision_mitigation import FINISH, EvasiveOption, hard_braking_mps2, least_harmful_option
from stucksolver.guard.context import CheckContext
from stucksolver.guard.early_return import early_return
from stucksolver.guard.hand_back import about_to_touch, clear_to_hand_back
from stucksolver.guard.path_tracking import swing_out_motion, tracked_path
from stucksolver.guard.policy import NOBODY, Approvals, GuardPolicy
from stucksolver.guard.proven_plan import CHECKS, ProvenPlan
from stucksolver.guard.turn_around import ProvenLeg, prove_turn, recheck_leg
from stucksolver.guard.verdict import OK, RejectReason, Verdict, no_path
from stucksolver.guard.yielding import stop_out_of_paths, waits_outside, yields_now
from stucksolver.plan.behaviors import (
    AbortAction,
    Behavior,
    BehaviorStart,
    Check,
    LegBehavior,
    NoPathError,
)
from stucksolver.plan.behaviors.registry import unknown_behavior_reason
from stucksolver.plan.frenet_path import FrenetPath, lateral, shortest_shift
from stucksolver.scene.failed_attempts import PlanFailure, RejectCode
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.plausibility import implausibility
from stucksolver.scene.road import LaneDirection, ZoneKind

MOST = 6
"""Maximum number of behaviors in a plan: a bound on the work of one check."""


class Guard:
    """Checker that accepts, rejects and aborts plans. Its policy is fixed when it is created.

    Args:
        policy: Bounds that no plan may cross; the design's defaults if None.
    """

    def __init__(self, policy: GuardPolicy | None = None) -> None:
        self.policy = policy or GuardPolicy()

    def accept(
        self,
        behaviors: Sequence[Behavior],
        view: FrenetScene,
        guided: bool,
        approvals: Approvals = NOBODY,
        stops: bool = False,
    ) -> tuple[Verdict, ProvenPlan | None]:
        """Check moving behaviors as one path from the ego's present state.

        Args:
            behaviors: Behaviors, in order.
            view: Surroundings in road coordinates.
            guided: True if the passenger's guidance requests the plan.
            approvals: Approvals by people.
            stops: True if the path must end in a stop, because the next behavior has no motion or is checked there.

        Returns:
            Verdict, and the proven path (None if rejected).
        """
        wrong = _implausible_input(behaviors, view)
        if wrong is not None:
            return Verdict(rejects=(wrong,)), None
        # The cheap checks come first: without fresh surroundings and approvals, a path proves nothing.
        first = [r for r in (self._stale(view), *(self._lacks_approval(b, approvals) for b in behaviors)) if r]
        if first:
            return Verdict(rejects=tuple(first)), None
        try:
            proven = self.lay_out(behaviors, view, guided, approvals, stops)
        except NoPathError as error:
            return no_path(error), None
        view = self._facing(view, proven)
        tracked = tracked_path(proven.path, view, self.policy.tracking, reverse=proven.reverse)
        case = proven.context(view, tracked, self.policy)
        rejects = self._run(proven.checks, case) or self._swings(case, proven) or early_return(case, proven.no_stop)
        rejects = rejects or are_stops_safe(case, proven.no_stop)
        if stops:
            rejects = rejects or traffic_rules.no_worse_place(case)
        return (
            (Verdict(rejects=tuple(rejects)), None)
            if rejects
            else (Verdict(sight=oncoming_lane.proof_of(case)), proven)
        )

    def accept_turn(
        self, behavior: LegBehavior, view: FrenetScene, approvals: Approvals = NOBODY
    ) -> tuple[Verdict, ProvenLeg | None]:
        """Check the rest of a turn from the ego's present pose.

        Returns:
            Verdict, and the first leg (None if rejected).
        """
        wrong = _implausible_input((behavior,), view) or self._stale(view) or self._lacks_approval(behavior, approvals)
        if wrong is not None:
            return Verdict(rejects=(wrong,)), None
        return prove_turn(behavior, view, self.policy, approvals)

    def recheck_turn(self, proven: ProvenLeg, view: FrenetScene) -> Verdict:
        """Check a running leg of a turn on this tick. A rejection has the abort: stop or yield."""
        old = self._stale(view)
        if old is not None:
            return Verdict(rejects=(old,), abort=AbortAction.YIELD, brake_mps2=view.ego.limits.comfort_braking_mps2)
        return recheck_leg(proven, view, self.policy)

    def allows_standing(self, behavior: Behavior, view: FrenetScene, approvals: Approvals = NOBODY) -> Verdict:
        """Check a behavior without motion."""
        old = _implausible_input((behavior,), view) or self._stale(view) or self._lacks_approval(behavior, approvals)
        why = behavior.precondition(view)
        if old:
            return Verdict(rejects=(old,))
        detail = behavior.stopping_place_detail
        if why is None and detail is not None and not self.may_stand(view):
            return Verdict(rejects=(RejectReason(code=RejectCode.STOPPING_PLACE, detail=detail),))
        return Verdict(rejects=(RejectReason(code=RejectCode.PRECONDITION, detail=why),)) if why else OK

    def recheck(self, proven: ProvenPlan, view: FrenetScene, giving_way: lane_entry.GivingWay = False) -> Verdict:
        """Check a running plan on this tick.

        Args:
            proven: Accepted plan.
            view: Surroundings in road coordinates.
            giving_way: Vehicles to which the last abort yielded. The plan continues only if the path stays clear long
                enough.

        Returns:
            Verdict. If it has reject reasons, it has the abort as well.
        """
        view = self._facing(view, proven)
        case = self._running(proven, view)
        off = self._off_path(case.error_m) or self._too_fast(proven, view)
        old = self._stale(view)
        if not proven.committed(view.ego_s):
            early = [reject for reject in (old, off) if reject]
            rejects = early or self._run(proven.checks_on_tick, case) or self._swings(case, proven)
            return self._aborted(case, rejects) if rejects else OK
        if old is not None:
            return Verdict(rejects=(old,), abort=AbortAction.YIELD if giving_way else AbortAction.STOP_SOON)
        if not case.in_oncoming_lane:
            red = path_checks.stop_line(case)
            if red:
                return Verdict(rejects=tuple(red), abort=AbortAction.STOP, brake_mps2=hard_braking_mps2(case))
        if proven.reverse and (ends := back_up.must_stop(case, off)) is not None:
            return ends
        case = replace(case, sets_off=bool(giving_way) and waits_outside(case))
        rejects = ([off] if off else []) + path_checks.collision(case)
        pressing = [] if proven.reverse else lane_entry.check_rear_traffic_can_stop(case, giving_way)
        option = self._after_commit(case, proven, rejects, pressing, bool(giving_way))
        if option is None:
            return OK
        return Verdict(rejects=tuple(rejects + pressing), abort=option.abort, brake_mps2=option.brake_mps2)

    def harder_stop(self, proven: ProvenPlan, view: FrenetScene) -> float | None:
        """Return the deceleration for the rest of a stop that has begun (m/s²); None if gentle braking hits no object.

        Args:
            proven: Plan that the stop ended.
            view: Surroundings in road coordinates.
        """
        return None if self._stale(view) else hard_braking_mps2(self._running(proven, self._facing(view, proven)))

    def _running(self, proven: ProvenPlan, view: FrenetScene) -> CheckContext:
        """Return the rest of a running plan, from the ego's present pose."""
        error_m, error_rad = self._error(proven.path, view)
        rest = tracked_path(proven.path.from_station(view.ego_s), view, self.policy.tracking, reverse=proven.reverse)
        # The stack's window of the road moves with the ego, so the entered lanes are taken from the present window.
        rest = replace(rest, enters=tuple(view.frame.same_lane(lane) for lane in rest.enters))
        case = proven.context(view, rest, self.policy)
        return replace(case, running=True, error_m=error_m, error_rad=error_rad)

    def _after_commit(
        self,
        case: CheckContext,
        proven: ProvenPlan,
        rejects: list[RejectReason],
        pressing: list[RejectReason],
        giving_way: bool,
    ) -> EvasiveOption | None:
        """Return the best option if it is uncertain whether to continue; None to continue the plan.

        The order is: a return into the lane, a stop that lets others pass, the option with the least harm.
        """
        off = any(r.code in (RejectCode.DEVIATION, RejectCode.OVERSPEED) for r in rejects)
        wanted = {b.abort_after_commit for b in proven.behaviors}
        if rejects and AbortAction.RETURN_TO_LANE in wanted and self.way_back(case.view) is not None:
            return EvasiveOption(AbortAction.RETURN_TO_LANE)
        yields = stop_out_of_paths if not off and is_junction_stop_clear(case, rejects, giving_way) else yields_now
        if (braking := yields(case, rejects, giving_way)) is not None:
            if not braking:
                return FINISH
            gentle = braking == case.view.ego.limits.comfort_braking_mps2
            return EvasiveOption(AbortAction.YIELD, None if gentle else braking)
        if not off and (pressing or giving_way) and stops_beside(case, rejects + pressing, giving_way):
            return EvasiveOption(AbortAction.YIELD)
        return least_harmful_option(case, giving_way) if rejects else None

    def _aborted(self, case: CheckContext, rejects: list[RejectReason]) -> Verdict:
        action = self._before_commit(case.view)
        hard = (
            (speed_caps.brakes_for_door(case, rejects) or hard_braking_mps2(case))
            if action is AbortAction.STOP
            else None
        )
        return Verdict(rejects=tuple(rejects), abort=action, brake_mps2=hard)

    def _before_commit(self, view: FrenetScene) -> AbortAction:
        """Return the abort: a stop, unless the ego has strayed into an oncoming lane and must not stop there."""
        lane = view.ego_lane
        if lane is None or lane.strip.direction is not LaneDirection.OPPOSITE:
            return AbortAction.STOP
        return AbortAction.FINISH if self.way_back(view) is None else AbortAction.RETURN_TO_LANE

    def may_stand(self, view: FrenetScene) -> bool:
        """True if the ego may stop here: outside junctions, crosswalks, level crossings and oncoming lanes."""
        if view.zone_at(view.ego_s) is not None:
            return False
        half = view.ego.width_m / 2 - self.policy.lanes.standing_edge_m
        lanes = (view.frame.lane_at(view.ego_s, view.ego_d + side) for side in (-half, 0.0, half))
        return not any(lane is not None and lane.strip.direction is LaneDirection.OPPOSITE for lane in lanes)

    def stopping_soon(self, path: FrenetPath, view: FrenetScene, reverse: bool = False) -> FrenetPath | None:
        """Return the end of a path after a failure of perception past the commit point; None to brake at once.

        From an oncoming lane it leads back into the ego's own lane, if that path was free in the last surroundings.

        Args:
            path: Running path.
            view: Last surroundings, in road coordinates.
            reverse: True if the path backs up.
        """
        view = view.backwards if reverse else view
        case = CheckContext(view, path.from_station(view.ego_s), self.policy, running=True)
        if case.in_oncoming_lane and not reverse:
            back = self.way_back(view)
            case = case if back is None else replace(case, path=back)
        slowly = stopping_soon(case)
        rejects = path_checks.collision(
            replace(case, path=tracked_path(slowly, view, self.policy.tracking, reverse=reverse))
        )
        if not rejects:
            return slowly
        ends = replace(case, path=slowly)
        brakes = (
            stop_out_of_paths(ends, rejects) is not None or least_harmful_option(ends, False).abort is AbortAction.YIELD
        )
        return None if brakes else slowly

    def is_stale(self, view: FrenetScene) -> bool:
        """True if the surroundings are too old for any check."""
        return self._stale(view) is not None

    def way_back(self, view: FrenetScene) -> FrenetPath | None:
        """Return a path without contact from here into the route's lane, or None. It ends on no level crossing."""
        policy = self.policy.stopping
        speed, tightest = max(view.ego.speed_mps, policy.return_least_mps), view.ego.limits.min_turn_radius_m
        length = max(policy.return_s * speed, shortest_shift(view.ego_d, tightest), policy.return_least_m)
        path = lateral(view.ego_s, view.ego_d, 0.0, length, speed, view)
        strict = CheckContext(view, tracked_path(path, view, self.policy.tracking), self.policy)
        if path_checks.drivable_area(strict) or view.zone_at(path.end_s, ZoneKind.LEVEL_CROSSING) is not None:
            return None
        if not path_checks.collision(strict):
            return path
        # Smaller gaps are accepted only to get out of an oncoming lane.
        loose = replace(strict, running=True)
        return path if strict.in_oncoming_lane and not path_checks.collision(loose) else None

    def recheck_way_back(self, path: FrenetPath, view: FrenetScene, giving_way: bool = False) -> Verdict:
        """Check a path back into the lane on this tick. A rejection has the abort: brake or finish."""
        rest = tracked_path(path.from_station(view.ego_s), view, self.policy.tracking)
        error_m, error_rad = self._error(path, view)
        case = CheckContext(view, rest, self.policy, running=True, error_m=error_m, error_rad=error_rad)
        rejects = path_checks.collision(case)
        if not rejects:
            return OK
        option = least_harmful_option(case, giving_way)
        return Verdict(rejects=tuple(rejects), abort=option.abort, brake_mps2=option.brake_mps2)

    def clear_to_hand_back(self, view: FrenetScene) -> bool:
        """True if the stack may resume driving from here, or must because no vehicle may stop here."""
        return not self.may_stand(view) or clear_to_hand_back(view, self.policy)

    def about_to_touch(self, view: FrenetScene, curvature_per_m: float) -> RejectReason | None:
        """Return the contact of the driver unless the guard brakes hard now; None without one or with stale data."""
        return None if self._stale(view) else about_to_touch(view, self.policy, curvature_per_m)

    def lay_out(
        self, behaviors: Sequence[Behavior], view: FrenetScene, guided: bool, approvals: Approvals, stops: bool = False
    ) -> ProvenPlan:
        """Plan behaviors as one path from here, without checking it. The arguments are those of `accept`.

        Raises:
            NoPathError: The behaviors have no path here.
        """
        if len({b.reverse for b in behaviors}) > 1:
            raise NoPathError(
                PlanFailure.MUST_BE_STOPPED, "the vehicle must stop between driving forward and backing up"
            )
        view = view.backwards if behaviors and behaviors[0].reverse else view
        start = BehaviorStart(view.ego_s, view.ego_d, view.ego.speed_mps, view.ego_yaw)
        path: FrenetPath | None = None
        ends: list[float] = []
        for k, behavior in enumerate(behaviors):
            why = behavior.precondition(view) if k == 0 else None
            part = None if why else behavior.maneuver(view, start)
            if part is None:
                raise NoPathError(PlanFailure.PRECONDITION, why or f"{behavior.name} has no path")
            path = part if path is None else path.then(part)
            ends.append(part.end_s)
            start = BehaviorStart(part.end_s, part.end_d, float(part.speed[-1]))
        if path is None:
            raise NoPathError(PlanFailure.EMPTY, "the plan is empty")
        path = path.stopping() if stops else path
        path = speed_caps.within_limits(path, view, self.policy, reverse=behaviors[0].reverse)
        case = CheckContext(view, path, self.policy, guided)
        return ProvenPlan(
            tuple(behaviors),
            path,
            tuple(ends),
            commit_mask(case),
            case.slow.duration_s,
            guided,
            approvals,
            abs(view.ego.speed_mps),
            path_checks.stopped_at(view, self.policy),
        )

    @staticmethod
    def _facing(view: FrenetScene, proven: ProvenPlan) -> FrenetScene:
        return view.backwards if proven.reverse else view

    def _run(self, names: tuple[Check, ...], case: CheckContext) -> list[RejectReason]:
        return [reject for name in names for reject in CHECKS[name](case)]

    def _swings(self, case: CheckContext, proven: ProvenPlan) -> list[RejectReason]:
        """Return the reject reasons of backing up at an angle if the body is not straightened on the way."""
        if not proven.reverse:
            return []
        path = proven.path.from_station(case.view.ego_s) if case.running else proven.path
        straight = swing_out_motion(path, case.view, self.policy.tracking, self.policy.stopping.lag_s)
        if straight is None:
            return []
        # For an ego that backs up, oncoming traffic approaches from behind.
        askew = replace(case, path=straight)
        return path_checks.collision(askew) + from_behind(askew)

    def _lacks_approval(self, behavior: Behavior, approvals: Approvals) -> RejectReason | None:
        needed = self.policy.release(behavior.name)
        if approvals.cover(behavior.name, needed):
            return None
        detail = f"{behavior.name}: requires approval from the {needed.value}"
        return RejectReason(code=RejectCode.APPROVAL, detail=detail)

    def _stale(self, view: FrenetScene) -> RejectReason | None:
        age_s, most_s = view.surroundings.age_s, self.policy.max_age_s
        detail = f"surroundings: age {age_s:.1f} s, allowed {most_s:.1f} s"
        return RejectReason(code=RejectCode.STALE, detail=detail) if age_s > most_s else None

    def _too_fast(self, proven: ProvenPlan, view: FrenetScene) -> RejectReason | None:
        """Check that the ego keeps to the plan's speed. It may be faster only if it was when the plan began."""
        cap = float(proven.path.speed.max()) + self.policy.speeds.tolerance_mps
        now = abs(view.ego.speed_mps)
        if now <= max(cap, proven.start_mps):
            return None
        return RejectReason(
            code=RejectCode.OVERSPEED, detail=f"speed {now:.1f} m/s exceeds the plan's limit of {cap:.1f} m/s"
        )

    def _off_path(self, error_m: float) -> RejectReason | None:
        off_m, most_m = abs(error_m), self.policy.tracking.error_m
        detail = f"ego {off_m:.2f} m off the proven path, allowed {most_m:.2f} m"
        return RejectReason(code=RejectCode.DEVIATION, detail=detail, gap_m=off_m) if off_m > most_m else None

    @staticmethod
    def _error(path: FrenetPath, view: FrenetScene) -> tuple[float, float]:
        """Return the lateral distance from the proven path (m) and the heading error (rad), left positive."""
        offset = view.ego_d - float(np.interp(view.ego_s, path.s, path.d))
        return offset, view.ego_yaw - float(np.interp(view.ego_s, path.s, path.heading()))


def _implausible_input(behaviors: Sequence[Behavior], view: FrenetScene) -> RejectReason | None:
    """Check that the surroundings are plausible, and that the behaviors are known and within their bounds."""
    wrong = implausibility(view.surroundings) or next(
        (why for b in behaviors[:MOST] if (why := unknown_behavior_reason(b))), None
    )
    if wrong is None and len(behaviors) > MOST:
        wrong = f"{len(behaviors)} behaviors, allowed {MOST}"
    return None if wrong is None else RejectReason(code=RejectCode.IMPLAUSIBLE, detail=wrong)
