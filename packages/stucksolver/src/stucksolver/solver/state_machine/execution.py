"""Executes an accepted plan, one behavior after another; the guard checks it at every tick."""

from __future__ import annotations

import copy
from dataclasses import replace

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
from stucksolver.plan import Execute, RecoveryPlan
from stucksolver.plan.behaviors import (
    AbortAction,
    Behavior,
    KeepLane,
    Wait,
    drives_legs,
)
from stucksolver.plan.frenet_path import landing_m
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution_phases import (
    AwaitingNext,
    Ending,
    OnLeg,
    OnPath,
    Phase,
    Returning,
    Stopped,
    Yielding,
)
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome, NextStep, Step, stand
from stucksolver.solver.state_machine.gap_wait import STOPPED_MPS, GapWait, yield_targets
from stucksolver.solver.state_machine.next_step import awaiting_next
from stucksolver.solver.state_machine.path_points import (
    ARRIVED_M,
    along_leg,
    along_path,
    along_way_back,
    blind_stop,
    facing,
    has_arrived,
)
from stucksolver.solver.state_machine.segments import later_turn_released, segments_of

BACK_IN_LANE_M = 0.4
LEG_LEFT_M = 1.0
"""A leg of a turn counts as driven at this distance before its end, or at half its length, once the vehicle stands."""
STALLED_S = 1.5
"""A vehicle that has stood this long at the end of a leg will go no further."""
LEG_ENDS_M = 0.2
"""The vehicle brakes for the end of a leg from this distance."""
MOST_LEGS = 10
"""A turn may begin this many legs, twice as many as planned: each begins where the last one really ended."""
GAP_WAIT_S = 120.0
"""A plan yields this long on its path, where it cannot simply end."""
NEXT_STEP_S = 30.0
"""A plan waits this long for a gap before its next step, by default (s), as `QuestionSettings.next_step_s`."""
RETURN_WAIT_S = 30.0
"""A vehicle at the roadside waits this long for a proven return; then the stack merges by itself. Ours."""


class Execution:
    """One running plan. Call `start`, then `tick` until it returns an `ExecutionOutcome`.

    `phase` is what it does now (`execution_phases`). Its members are never changed in place, so a shallow copy
    (`advance`, `withdrawn`) is independent of the original.
    """

    def __init__(self, plan: RecoveryPlan, guard: Guard, guided: bool, approvals: Approvals = NOBODY) -> None:
        self.plan = plan
        self.phase: Phase = Stopped()
        self.last_verdict = Verdict()
        self.step_done = False
        """True once a step with a path is done."""
        self._next_step_s = NEXT_STEP_S
        self._guard = guard
        self._guided = guided
        self._approvals = approvals
        self._segments: tuple[tuple[Behavior, ...], ...] = segments_of(plan.behaviors)
        self._behavior: Behavior = plan.behaviors[0]
        self._directive: Step = stand(None)
        self._until_s = 0.0
        self._legs_begun = 0
        self._withdrawn = False

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
        lacking = (
            later_turn_released(self._segments[1:], proven, view, self._guard.policy, self._approvals)
            if verdict.accepted
            else OK
        )
        if not lacking.accepted:
            return lacking
        if verdict.accepted:
            self._begin(proven, leg, view, now_s)
        return verdict

    def _begin(self, proven: ProvenPlan | None, leg: ProvenLeg | None, view: FrenetScene, now_s: float) -> None:
        segment, self._segments = self._segments[0], self._segments[1:]
        self._behavior = segment[0]
        if leg is not None:
            before = self.phase
            self.phase = OnLeg(leg, before.moved_s if isinstance(before, OnLeg) else 0.0)
        else:
            self.phase = Stopped() if proven is None else OnPath(proven)
        moves = proven or leg
        expected = moves.expected_s if moves else 0.0
        self._until_s = now_s + max(b.time_allowance_s(expected) for b in segment)
        self._directive = self._direct(view)

    def withdraw(self) -> None:
        """Give the plan up as soon as that is safe: at once before the commit point, otherwise at its end."""
        self._withdrawn = True

    def withdrawn(self) -> Execution:
        """A copy of this plan that will be given up as soon as that is safe."""
        other = copy.copy(self)
        other.withdraw()
        return other

    def advance(
        self, view: FrenetScene, now_s: float, next_step_s: float = NEXT_STEP_S
    ) -> tuple[Execution, Step | ExecutionOutcome]:
        """Return a copy advanced by one tick, with the step to take or the outcome. This object does not change.

        Args:
            view: The surroundings in road coordinates.
            now_s: The solver's own time (s).
            next_step_s: How long to wait for traffic before the next step (s).
        """
        other = copy.copy(self)
        other._next_step_s = next_step_s
        return other, other.tick(view, now_s)

    def tick(self, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        """Return what to do at this tick, or how the plan ended."""
        phase = self.phase
        if isinstance(phase, Ending):
            return self._stop(phase, view)
        if isinstance(phase, Returning):
            return self._return(phase, view)
        yields = self._yields and abs(view.ego.speed_mps) < STOPPED_MPS and self._guard.may_stand(view)
        if self._withdrawn and (yields or not self._committed(view)):
            return self._abort(AbortAction.STOP, OK, view, "withdrawn")
        if isinstance(phase, AwaitingNext):
            return self._next(view, now_s)
        if isinstance(phase, OnLeg):
            return self._turn(phase, view, now_s)
        if isinstance(phase, OnPath):
            return self._move(phase, view, now_s)
        return self._stand(phase, view, now_s)

    @property
    def is_waiting(self) -> bool:
        """True if the plan stands for traffic, between two steps or on its path, or in a behavior without a path."""
        return isinstance(self.phase, AwaitingNext | Stopped) or self._yields

    @property
    def is_stopping_blind(self) -> bool:
        """True if perception has failed past the commit point and the vehicle is led to a stop."""
        return isinstance(self.phase, OnPath | Returning) and self.phase.blind is not None

    @property
    def _yields(self) -> bool:
        """True if the vehicle brakes for other road users."""
        phase = self.phase
        return phase.yielding is not None if isinstance(phase, OnPath) else isinstance(phase, OnLeg) and phase.yields

    def _committed(self, view: FrenetScene) -> bool:
        phase = self.phase
        if isinstance(phase, OnLeg):
            return phase.leg.behavior.must_finish(view)
        if not isinstance(phase, OnPath):
            return False
        if self._withdrawn and phase.proven.path.over:
            return False  # whoever calls a stop may know that it is no bag
        return phase.proven.committed(facing(view, phase.proven).ego_s)

    def _stand(self, phase: Stopped, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        if phase.shown and (now_s >= self._until_s - 1e-6 or self._behavior.done(view)):
            return self._next(view, now_s)
        self.phase = Stopped(shown=True)
        return self._directive

    def _move(self, phase: OnPath, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        proven = phase.proven
        giving_way: GivingWay = False if phase.yielding is None else phase.yielding.to
        self.last_verdict = verdict = self._guard.recheck(proven, view, giving_way)
        if verdict.abort is AbortAction.YIELD:
            return self._give_way(phase, verdict, view, now_s)
        if verdict.abort is AbortAction.STOP_SOON:
            blind = phase.blind or blind_stop(self._guard, proven.path, view, self._behavior, proven.reverse)
            self.phase = replace(phase, blind=blind)
            return blind
        if phase.yielding is not None or phase.blind is not None:
            self.phase = phase = replace(phase, yielding=None, blind=None)
            self._directive = self._direct(view)
        if not verdict.accepted and verdict.abort is not AbortAction.FINISH:
            return self._abort(verdict.abort or AbortAction.STOP, verdict, view)
        seen = facing(view, proven)
        if now_s > self._until_s and not proven.committed(seen.ego_s):
            late = RejectReason(code=RejectCode.TIMEOUT, detail="it took longer than its time allowance")
            self.last_verdict = Verdict(rejects=(late,), abort=AbortAction.STOP)
            return self._abort(AbortAction.STOP, self.last_verdict, view)
        if has_arrived(proven, seen) or (self._behavior.done(view) and not proven.committed(seen.ego_s)):
            return self._next(view, now_s)
        index = phase.index
        while index < len(proven.ends_s) - 1 and seen.ego_s >= proven.ends_s[index] - ARRIVED_M:
            index += 1
            self._behavior = proven.behaviors[index]
            self.phase = replace(phase, index=index)
            self._directive = self._direct(view)
        return self._directive

    def _give_way(self, phase: OnPath, verdict: Verdict, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        """Brake for others with the plan still in force. Outside junctions this uses up none of its time."""
        before = phase.yielding or Yielding(False, now_s, now_s)
        gap_wait = GapWait.after(phase.gap_wait, verdict, view, now_s)
        if view.zone_at(view.ego_s) is None:
            self._until_s += now_s - before.last_s
            in_vain = gap_wait.has_timed_out(view.ego, now_s) and self._guard.may_stand(view)
            late = in_vain or now_s - before.since_s > GAP_WAIT_S
        else:
            # The stack can get through a junction by itself; a plan does not leave it standing there.
            late = now_s > self._until_s
        if late:
            stays = gap_wait.in_vain_s is not None
            why = "what is in its way does not move" if stays else "it gave way for longer than its time allowance"
            return ExecutionOutcome(False, f"{why}: {verdict}", verdict)
        others = yield_targets(verdict, view.ego, before.to)
        self.phase = replace(phase, yielding=Yielding(others, before.since_s, now_s), gap_wait=gap_wait)
        return stand(verdict.brake_mps2)

    def _turn(self, phase: OnLeg, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        """Continue a leg of a turn. Stop for someone near, or at the end of the leg, where the next one begins."""
        leg = phase.leg
        refused, verdict = self.last_verdict, self._guard.recheck_turn(leg, view)
        self.last_verdict = verdict
        rests = abs(view.ego.speed_mps) < STOPPED_MPS
        if now_s > self._until_s:
            why = refused if verdict.accepted else verdict
            return self._abort(AbortAction.STOP, why, view, f"the turn took longer than its time allowance: {why}")
        if verdict.abort is AbortAction.YIELD:
            self.phase = replace(phase, yields=True)
            return stand(verdict.brake_mps2)
        left_m = leg.left_m(view)
        moved_s = phase.moved_s if rests else now_s
        self.phase = phase = replace(phase, moved_s=moved_s)
        driven = left_m < min(LEG_LEFT_M, leg.leg.length_m / 2)
        # The stack brakes for near objects by itself; the turn continues from where it stopped.
        stalled = now_s - moved_s > STALLED_S and left_m < leg.leg.length_m - LEG_LEFT_M / 2
        if rests and (driven or stalled or not verdict.accepted):
            return self._next_leg(phase, view, now_s)
        if left_m < LEG_ENDS_M or not verdict.accepted:
            return stand(verdict.brake_mps2)
        if phase.yields:
            self.phase = replace(phase, yields=False)
            self._directive = self._direct(view)
        return self._directive

    def _next_leg(self, phase: OnLeg, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        """Finish the turn, or begin its next leg, planned and proven from where the vehicle really stands."""
        self.phase = replace(phase, yields=False)
        behavior = phase.leg.behavior
        if behavior.done(view):
            return self._next(view, now_s)
        after, self._segments = self._segments, ((behavior,), *self._segments)
        verdict = self.start(view, now_s)
        self._legs_begun += verdict.accepted
        if verdict.accepted and self._legs_begun < MOST_LEGS:
            return self._directive
        self._segments, self.last_verdict = after, verdict
        if verdict.accepted or RejectCode.NO_PATH in verdict.codes:
            return self._abort(AbortAction.STOP, verdict, view, f"the turn cannot be finished: {verdict}")
        return stand(None)

    def _next(self, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        self.step_done = self.step_done or isinstance(self.phase, OnPath | OnLeg)
        if not self._segments:
            return ExecutionOutcome(True, "the plan is done")
        verdict = self.start(view, now_s)
        if not verdict.accepted:
            return self._await_gap(verdict, view, now_s)
        if isinstance(self.phase, Stopped):
            self.phase = Stopped(shown=True)
        return self._directive

    def _await_gap(self, verdict: Verdict, view: FrenetScene, now_s: float) -> Step | ExecutionOutcome:
        """Stand and try the next step again on every tick if only traffic is in its way; otherwise give up.

        With the nose out, a lane change begins at once, by giving way.
        """
        self.last_verdict = verdict
        # At the roadside the vehicle stands safely, whatever keeps it there; the stack would drive back unproven.
        returns = self._segments[0][0].starts_at_roadside
        before = self.phase if isinstance(self.phase, AwaitingNext) else None
        wait_s = RETURN_WAIT_S if returns else self._next_step_s
        waiting, passing = awaiting_next(before, verdict, view, now_s, wait_s, returns=returns)
        self.phase = waiting
        if passing and now_s < waiting.until_s and self._guard.may_stand(view):
            stops = len(self._segments) > 1
            begun = begin_nosed_out(self._guard, self._segments[0], view, self._guided, self._approvals, stops)
            if begun is not None:
                self.last_verdict, proven = begun
                self._begin(proven, None, view, now_s)
                return self._give_way(OnPath(proven), self.last_verdict, view, now_s)
            return stand(None)
        why = f"no gap within {wait_s:g} s" if passing else "the next step was refused"
        ended = NextStep.TIMED_OUT if passing else NextStep.REFUSED
        return self._abort(AbortAction.STOP, verdict, view, f"{why}: {verdict}", ended)

    def _abort(
        self,
        way: AbortAction,
        verdict: Verdict,
        view: FrenetScene,
        why: str | None = None,
        step: NextStep | None = None,
    ) -> Step | ExecutionOutcome:
        """End the plan: stop if the place allows it, else drive back, else hand over at once.

        After a hand-over the stack drives on by itself. The vehicle never stands where nobody should.
        """
        before = self.phase
        outcome = ExecutionOutcome(False, why or str(verdict), verdict, step)
        if way is AbortAction.RETURN_TO_LANE or not self._guard.may_stand(view):
            way_back = self._guard.way_back(view)
            if way_back is None:
                return outcome
            directive = along_way_back(way_back, view)
            blind = before.blind if isinstance(before, OnPath) else None
            return self._return(Returning(outcome, way_back, directive, self._yields, blind), view)
        stop = Execute(behavior=Wait(duration_s=2.0), brake_mps2=self.last_verdict.brake_mps2)
        return self._stop(Ending(outcome, stop, before.proven if isinstance(before, OnPath) else None), view)

    def _stop(self, phase: Ending, view: FrenetScene) -> Step | ExecutionOutcome:
        """Continue the abort until the ego stands."""
        self.phase = phase
        if abs(view.ego.speed_mps) < STOPPED_MPS:
            return phase.outcome
        hard = None if phase.proven is None else self._guard.harder_stop(phase.proven, view)
        if hard is not None:
            self.phase = phase = replace(phase, directive=stand(hard))
        return phase.directive

    def _return(self, phase: Returning, view: FrenetScene) -> Step | ExecutionOutcome:
        """Continue on the way back, or stop for someone who would be touched. Hand over if the ego stands."""
        self.phase, path = phase, phase.path
        landed_s = path.end_s - landing_m(view.ego.speed_mps)
        if abs(view.ego_d) < BACK_IN_LANE_M or view.ego_s >= landed_s:
            return phase.outcome
        if self._guard.is_stale(view):
            slow = KeepLane(distance_m=5.0, speed_mps=3.0)
            blind = phase.blind or blind_stop(self._guard, path, view, slow, reverse=False)
            self.phase = replace(phase, blind=blind)
            return blind
        verdict = self._guard.recheck_way_back(path, view, phase.yields)
        self.phase = replace(phase, yields=verdict.abort is AbortAction.YIELD, blind=None)
        if verdict.abort is not AbortAction.YIELD:
            return phase.directive
        return phase.outcome if abs(view.ego.speed_mps) < STOPPED_MPS else stand(verdict.brake_mps2)

    def _direct(self, view: FrenetScene) -> Step:
        """Return what the stack should do for the current behavior."""
        behavior, phase = self._behavior, self.phase
        if isinstance(phase, OnLeg):
            return along_leg(phase.leg, view)
        own = behavior.directive()
        if own is not None:
            return own
        if not isinstance(phase, OnPath):
            return Execute(behavior=behavior)
        return along_path(phase.proven, view, behavior, over_red="red_light" in self._approvals.operator)
