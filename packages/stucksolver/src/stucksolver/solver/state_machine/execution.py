"""Executes an accepted plan, one behaviour after another; the guard checks it at every tick."""

from __future__ import annotations

import copy

import numpy as np

from stucksolver.guard import (
    NOBODY,
    OK,
    Approvals,
    GivingWay,
    Guard,
    ProvenLeg,
    ProvenPlan,
    RejectCode,
    RejectReason,
    Verdict,
    begin_nosed_out,
)
from stucksolver.guard.turn_around import unreleased_line
from stucksolver.plan import Execute, RecoveryPlan
from stucksolver.plan.behaviors import (
    AbortAction,
    Behavior,
    KeepLane,
    Wait,
    drives_legs,
)
from stucksolver.plan.frenet_path import FrenetPath, landing_m
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome, Step, stand
from stucksolver.solver.state_machine.gap_wait import STOPPED_MPS, GapWait, sight_may_improve, yield_targets
from stucksolver.solver.state_machine.history import moving, passes
from stucksolver.solver.state_machine.path_points import ARRIVED_M, along_leg, facing, has_arrived, path_points
from stucksolver.solver.state_machine.segments import segments_of

BACK_IN_LANE_M = 0.4
LEG_LEFT_M = 1.0
"""A leg of a turn counts as driven at this distance before its end, or at half its length if it is shorter, once
the vehicle stands.
"""
STALLED_S = 1.5
"""A vehicle that has stood this long at the end of a leg will go no further."""
LEG_ENDS_M = 0.2
"""The vehicle brakes for the end of a leg from this distance."""
MOST_LEGS = 10
"""A turn may begin this many legs, twice as many as planned, because each leg begins where the last one really
ended.
"""
GAP_WAIT_S = 120.0
"""A plan waits this long for a gap before its next step. Then a person is asked (`reasoners.rules.decide.NO_WAY_S`)."""
RETURN_WAIT_S = 30.0
"""A vehicle at the roadside waits this long for a proven return; then the stack merges by itself. Ours: a stream that
never ends would hold the vehicle there for good.
"""


class Execution:
    """One running plan. Call `start`, then `tick` until it returns an `ExecutionOutcome`.

    Its members are never changed in place, so a shallow copy (`ticked`, `withdrawn`) is independent of the original.
    """

    def __init__(self, plan: RecoveryPlan, guard: Guard, guided: bool, approvals: Approvals = NOBODY) -> None:
        self.plan = plan
        self._guard = guard
        self._guided = guided
        self._approvals = approvals
        self._segments: tuple[tuple[Behavior, ...], ...] = segments_of(plan.behaviors)
        self._proven: ProvenPlan | None = None
        self._leg: ProvenLeg | None = None
        self._legs_begun = 0
        self._moved_s = 0.0
        self._behavior: Behavior = plan.behaviors[0]
        self._directive: Step | None = None
        self._shown = False
        self._until_s = 0.0
        self._gap_until_s: float | None = None
        self._traffic_s = 0.0
        self._index = 0
        self._withdrawn = False
        self._ending: ExecutionOutcome | None = None
        self._way_back: FrenetPath | None = None
        self._gives_way: GivingWay = False
        self._gave_way_s = (0.0, 0.0)
        self._waiting: GapWait | None = None
        self._blind: Execute | None = None
        self.last_verdict = Verdict()
        self.next_was_refused = False
        """True if the plan ended because a later step was refused once an earlier one was done."""

    def start(self, view: FrenetScene, now_s: float) -> Verdict:
        """Have the guard prove the next stretch, and begin it if it is accepted."""
        segment = self._segments[0]
        proven: ProvenPlan | None = None
        leg: ProvenLeg | None = None
        first = segment[0]
        if drives_legs(first):
            verdict, leg = self._guard.accept_turn(first, view, self._approvals)
        elif first.stands_still:
            verdict = self._guard.allows_standing(first, view, self._approvals)
        else:
            # Only the last stretch of a plan may end in motion, because the stack drives on from there. A stop before
            # the next stretch, or after its refusal, would lead beyond the proven path.
            stops = len(self._segments) > 1
            verdict, proven = self._guard.accept(segment, view, self._guided, self._approvals, stops)
        lacking = self._turn_released(proven, view) if verdict.accepted else OK
        if not lacking.accepted:
            return lacking
        if verdict.accepted:
            self._begin(proven, leg, view, now_s)
        return verdict

    def _begin(self, proven: ProvenPlan | None, leg: ProvenLeg | None, view: FrenetScene, now_s: float) -> None:
        segment, self._segments = self._segments[0], self._segments[1:]
        self._proven, self._leg, self._behavior = proven, leg, segment[0]
        self._index, self._shown, self._waiting = 0, False, None
        moves = proven or leg
        expected = moves.expected_s if moves else 0.0
        self._until_s = now_s + max(b.time_allowance_s(expected) for b in segment)
        self._directive = self._direct(view)

    def _turn_released(self, proven: ProvenPlan | None, view: FrenetScene) -> Verdict:
        """Judge whether a turn later in the plan lacks an approval, before the stretch that leads to it begins."""
        turn = next((b for segment in self._segments[1:] for b in segment if drives_legs(b)), None)
        if turn is None:
            return OK
        at = (view.ego.x_m, view.ego.y_m)
        if proven is not None:
            x, y, _ = facing(view, proven).frame.to_local(np.array([proven.path.end_s]), np.array([proven.path.end_d]))
            at = (float(x[0]), float(y[0]))
        return unreleased_line(turn, at, view, self._guard.policy, self._approvals)

    def withdraw(self) -> None:
        """Give the plan up as soon as that is safe: at once before the commit point, otherwise at its end."""
        self._withdrawn = True

    def withdrawn(self) -> Execution:
        """A copy of this plan that will be given up as soon as that is safe."""
        other = copy.copy(self)
        other.withdraw()
        return other

    def advance(self, view: FrenetScene, now_s: float) -> tuple[Execution, Step | ExecutionOutcome]:
        """Return a copy advanced by one tick, with the step to take or the outcome. This object does not change."""
        other = copy.copy(self)
        return other, other.tick(view, now_s)

    def tick(self, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        """Return what to do at this tick, or how the plan ended."""
        if self._ending is not None:
            return self._end(view)
        waits = self._gives_way and abs(view.ego.speed_mps) < STOPPED_MPS and self._guard.may_stand(view)
        if self._withdrawn and (waits or not self._committed(view)):
            return self._abort(AbortAction.STOP, OK, view, "withdrawn")
        if self._gap_until_s is not None:
            return self._next(view, now_s)
        if self._leg is not None:
            return self._turn(self._leg, view, now_s)
        if self._proven is None:
            return self._stand(view, now_s)
        return self._move(self._proven, view, now_s)

    def _committed(self, view: FrenetScene) -> bool:
        if self._leg is not None:
            return self._leg.behavior.must_finish(view)
        if self._withdrawn and self._proven is not None and self._proven.path.over:
            return False  # whoever calls a stop may know that it is no bag
        return self._proven is not None and self._proven.committed(facing(view, self._proven).ego_s)

    def _stand(self, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        assert self._directive is not None
        if self._shown and (now_s >= self._until_s - 1e-6 or self._behavior.done(view)):
            return self._next(view, now_s)
        self._shown = True
        return self._directive

    def _move(self, proven: ProvenPlan, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        self.last_verdict = verdict = self._guard.recheck(proven, view, self._gives_way)
        if verdict.abort is AbortAction.YIELD:
            return self._give_way(verdict, view, now_s)
        if verdict.abort is AbortAction.STOP_SOON:
            return self._stop_soon(proven.path, view, proven.reverse)
        if self._gives_way or self._blind is not None:
            self._gives_way, self._blind, self._directive = False, None, self._direct(view)
        if not verdict.accepted and verdict.abort is not AbortAction.FINISH:
            return self._abort(verdict.abort or AbortAction.STOP, verdict, view)
        seen = facing(view, proven)
        if now_s > self._until_s and not proven.committed(seen.ego_s):
            late = RejectReason(code=RejectCode.TIMEOUT, detail="it took longer than its time allowance")
            self.last_verdict = Verdict(rejects=(late,), abort=AbortAction.STOP)
            return self._abort(AbortAction.STOP, self.last_verdict, view)
        if has_arrived(proven, seen) or (self._behavior.done(view) and not proven.committed(seen.ego_s)):
            self._proven = None
            return self._next(view, now_s)
        while self._index < len(proven.ends_s) - 1 and seen.ego_s >= proven.ends_s[self._index] - ARRIVED_M:
            self._index += 1
            self._behavior = proven.behaviors[self._index]
            self._directive = self._direct(view)
        assert self._directive is not None
        return self._directive

    @property
    def is_stopping_blind(self) -> bool:
        """True if perception has failed past the commit point and the vehicle is led to a stop."""
        return self._blind is not None

    def _stop_soon(self, path: FrenetPath, view: FrenetScene, reverse: bool = False) -> Execute:
        """Lead the vehicle slowly to a stop. It is computed once: what is known does not change until sight returns."""
        if self._blind is None:
            way = self._guard.stopping_soon(path, view, reverse)
            self._blind = stand(None)
            if way is not None:
                behavior = KeepLane(distance_m=5.0, speed_mps=3.0) if self._way_back is not None else self._behavior
                points = path_points(way, view.backwards if reverse else view, no_stop=True)
                self._blind = Execute(behavior=behavior, path=points, reverse=reverse)
        return self._blind

    def _give_way(self, verdict: Verdict, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        """Brake for others with the plan still in force. Outside junctions this uses up none of its time."""
        since_s, last_s = self._gave_way_s if self._gives_way else (now_s, now_s)
        self._gave_way_s = (since_s, now_s)
        self._waiting = GapWait.after(self._waiting, verdict, view, now_s)
        if view.zone_at(view.ego_s) is None:
            self._until_s += now_s - last_s
            in_vain = self._waiting.has_timed_out(view.ego, now_s) and self._guard.may_stand(view)
            late = in_vain or now_s - since_s > GAP_WAIT_S
        else:
            # The stack can get through a junction by itself; a plan does not leave it standing there.
            late = now_s > self._until_s
        if late:
            stays = self._waiting.in_vain_s is not None
            why = "what is in its way does not move" if stays else "it gave way for longer than its time allowance"
            return ExecutionOutcome(False, f"{why}: {verdict}", verdict)
        self._gives_way = yield_targets(verdict, view.ego, self._gives_way)
        return stand(verdict.brake_mps2)

    def _turn(self, leg: ProvenLeg, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        """Continue a leg of a turn. Stop for someone near, or at the end of the leg, where the next one begins."""
        refused, verdict = self.last_verdict, self._guard.recheck_turn(leg, view)
        self.last_verdict = verdict
        rests = abs(view.ego.speed_mps) < STOPPED_MPS
        if now_s > self._until_s:
            why = refused if verdict.accepted else verdict
            return self._abort(AbortAction.STOP, why, view, f"the turn took longer than its time allowance: {why}")
        if verdict.abort is AbortAction.YIELD:
            self._gives_way = True
            return stand(verdict.brake_mps2)
        left_m = leg.left_m(view)
        self._moved_s = self._moved_s if rests else now_s
        driven = left_m < min(LEG_LEFT_M, leg.leg.length_m / 2)
        # The stack brakes for near objects by itself; the turn continues from where it stopped.
        stalled = now_s - self._moved_s > STALLED_S and left_m < leg.leg.length_m - LEG_LEFT_M / 2
        if rests and (driven or stalled or not verdict.accepted):
            return self._next_leg(leg, view, now_s)
        if left_m < LEG_ENDS_M or not verdict.accepted:
            return stand(verdict.brake_mps2)
        if self._gives_way:
            self._gives_way, self._directive = False, self._direct(view)
        assert self._directive is not None
        return self._directive

    def _next_leg(self, leg: ProvenLeg, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        """Finish the turn, or begin its next leg, planned and proven from where the vehicle really stands."""
        self._gives_way = False
        if leg.behavior.done(view):
            self._leg = None
            return self._next(view, now_s)
        after, self._segments = self._segments, ((leg.behavior,), *self._segments)
        verdict = self.start(view, now_s)
        self._legs_begun += verdict.accepted
        if verdict.accepted and self._legs_begun < MOST_LEGS:
            assert self._directive is not None
            return self._directive
        self._segments, self.last_verdict = after, verdict
        if verdict.accepted or RejectCode.NO_PATH in verdict.codes:
            return self._abort(AbortAction.STOP, verdict, view, f"the turn cannot be finished: {verdict}")
        return stand(None)

    def _next(self, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        if not self._segments:
            return ExecutionOutcome(True, "the plan is done")
        verdict = self.start(view, now_s)
        if not verdict.accepted:
            return self._await_gap(verdict, view, now_s)
        assert self._directive is not None
        self._gap_until_s, self._shown = None, True
        return self._directive

    def _await_gap(self, verdict: Verdict, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        """Stand and try the next step again on every tick if only traffic is in its way; otherwise give up.

        With the nose out, a lane change begins at once, by giving way.
        """
        self.last_verdict = verdict
        self._leg = self._proven = None
        # At the roadside the vehicle stands safely, whatever keeps it there; the stack would drive back unproven.
        returns = self._segments[0][0].starts_at_roadside
        if self._gap_until_s is None:
            self._gap_until_s, self._traffic_s = now_s + (RETURN_WAIT_S if returns else GAP_WAIT_S), now_s
        passing = returns or passes(verdict, moving(view), sensed=view.ego.position_sd_m is not None)
        self._traffic_s = now_s if passing else self._traffic_s
        passing = passing or sight_may_improve(verdict, view.ego, now_s - self._traffic_s)
        if passing and now_s < self._gap_until_s and self._guard.may_stand(view):
            stops = len(self._segments) > 1
            begun = begin_nosed_out(self._guard, self._segments[0], view, self._guided, self._approvals, stops)
            if begun is not None:
                self.last_verdict, proven = begun
                self._gap_until_s = None
                self._begin(proven, None, view, now_s)
                return self._give_way(self.last_verdict, view, now_s)
            return stand(None)
        self._gap_until_s, self.next_was_refused = None, True
        return self._abort(AbortAction.STOP, verdict, view, f"the next step was refused: {verdict}")

    def _abort(
        self, way: AbortAction, verdict: Verdict, view: FrenetScene, why: str | None = None
    ) -> Step | ExecutionOutcome:
        """End the plan: stop if the place allows it, else drive back, else hand over at once.

        After a hand-over the stack drives on by itself. The vehicle never stands where nobody should.
        """
        self._ending = ExecutionOutcome(False, why or str(verdict), verdict)
        if way is AbortAction.RETURN_TO_LANE or not self._guard.may_stand(view):
            self._way_back = self._guard.way_back(view)
            if self._way_back is None:
                return self._ending
        if self._way_back is None:
            self._directive = Execute(behavior=Wait(duration_s=2.0), brake_mps2=self.last_verdict.brake_mps2)
        else:
            distance = min(max(self._way_back.end_s - view.ego_s, 5.0), 150.0)
            behavior = KeepLane(distance_m=distance, speed_mps=min(max(view.ego.speed_mps, 3.0), 11.0))
            self._directive = Execute(behavior=behavior, path=path_points(self._way_back, view, no_stop=True))
        return self._end(view)

    def _end(self, view: FrenetScene) -> Step | ExecutionOutcome:
        """Continue the abort until the ego stands, or is back in its lane."""
        assert self._ending is not None and self._directive is not None
        if self._way_back is not None:
            landed_s = self._way_back.end_s - landing_m(view.ego.speed_mps)
            done = abs(view.ego_d) < BACK_IN_LANE_M or view.ego_s >= landed_s
            return self._ending if done else self._go_back(self._way_back, view)
        if abs(view.ego.speed_mps) < STOPPED_MPS:
            return self._ending
        hard = None if self._proven is None else self._guard.harder_stop(self._proven, view)
        self._directive = self._directive if hard is None else stand(hard)
        return self._directive

    def _go_back(self, path: FrenetPath, view: FrenetScene) -> Step | ExecutionOutcome:
        """Continue on the way back, or stop for someone who would be touched. Hand over if the ego stands."""
        assert self._ending is not None and self._directive is not None
        if self._guard.is_stale(view):
            return self._stop_soon(path, view)
        self._blind = None
        verdict = self._guard.recheck_way_back(path, view, bool(self._gives_way))
        self._gives_way = verdict.abort is AbortAction.YIELD
        if not self._gives_way:
            return self._directive
        if abs(view.ego.speed_mps) < STOPPED_MPS:
            return self._ending
        return stand(verdict.brake_mps2)

    def _direct(self, view: FrenetScene) -> Step:
        """Return what the stack should do for the current behaviour."""
        behavior, proven = self._behavior, self._proven
        if self._leg is not None:
            return along_leg(self._leg, view)
        own = behavior.directive()
        if own is not None:
            return own
        if proven is None:
            return Execute(behavior=behavior)
        seen = facing(view, proven)
        rest = proven.path.from_station(seen.ego_s)
        path = path_points(rest, seen, np.array([proven.committed(float(s)) for s in rest.s]))
        return Execute(
            behavior=behavior,
            path=path,
            reverse=proven.reverse,
            ignore=proven.path.over,
            over_red="red_light" in self._approvals.operator,
        )
