"""The life of a plan: proposed, judged, held for a gap, begun, carried out, given up."""

from __future__ import annotations

from dataclasses import replace

from stucksolver.guard import NOBODY, Approvals, RejectCode, RejectReason, Verdict
from stucksolver.ladder import CallAssistance
from stucksolver.plan import CONTINUE, Directive, RecoveryPlan, Replan, intent_authorizes, plan_matches_intent
from stucksolver.plan.behaviors import Behavior
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.scene import AttemptOutcome, GuidanceIntent
from stucksolver.solver.events import EventKind, ExecutionTick, PlanReview
from stucksolver.solver.state_machine import hand_back
from stucksolver.solver.state_machine.admission import Admission, admit, union
from stucksolver.solver.state_machine.claims import as_guard_input
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome, NextStep, Step
from stucksolver.solver.state_machine.gap_wait import STOPPED_MPS
from stucksolver.solver.state_machine.guidance import end_words
from stucksolver.solver.state_machine.history import passes, signature
from stucksolver.solver.state_machine.human_in_the_loop import release, request_approval, stop_for_assistance
from stucksolver.solver.state_machine.minimal_risk import minimal_risk, stops_where_one_may_stand
from stucksolver.solver.state_machine.pending_transition import BLIND_LIMIT_S, PendingTransition
from stucksolver.solver.state_machine.state import AwaitingGap, Driving, Executing, MinimalRisk, Monitoring

HARDLY_BEGUN_M = 2.0
"""A plan given up for traffic before this distance was driven waits unchanged for the next gap."""
STANDS_THERE = "; it stands: the driver's own next second is not clear"
OBSERVED_AGAIN_S = 5.0
"""An observer who found a plan looks again after this time."""

# ---- judging


def judge(turn: PendingTransition, answer: ReasonerAnswer, plan: RecoveryPlan) -> Directive | None:
    """Judge a plan against the world as it is now, not as it was when the question was asked.

    Returns:
        The directive, or None if the plan was refused and the reasoner may be told why and asked again at once.
    """
    turn.state = replace(turn.state, activity=Monitoring())
    reading = turn.state.reading
    turn.begin(turn.state.trigger)
    stopped = isinstance(turn.state.posture, MinimalRisk)
    if turn.inputs.trigger is None and not plan_matches_intent(reading, plan) and not stopped:
        gone = RejectReason(code=RejectCode.NOT_IMMOBILIZED, detail="the vehicle moves again")
        turn.tell_decision(answer, Verdict(rejects=(gone,)))
        return CONTINUE
    judged = _admitted(turn, plan, guided=intent_authorizes(reading, plan), approvals=_approvals(turn, plan))
    if judged is None:
        turn.tell(EventKind.FAILED, "there are no surroundings to check the plan against")
        turn.failed()
        return turn.resting
    turn.tell_decision(answer, judged.verdict)
    if turn.setup.observe_only:
        turn.pause(turn.now_s + OBSERVED_AGAIN_S)
        return CONTINUE
    if judged.verdict.accepted:
        return start(turn, judged, answer)
    if judged.need is not None:
        request_approval(turn, judged, answer)
        return turn.resting
    return _refused(turn, judged, answer)


def _refused(turn: PendingTransition, judged: Admission, answer: ReasonerAnswer) -> Directive | None:
    """Hold the plan for a gap if only traffic prevents it; otherwise tell the reasoner why it was refused.

    The reasoner is asked again at once while repair rounds are left.
    """
    if judged.passing and not turn.is_blind:
        until = turn.now_s + turn.setup.ladder.asking.hold_s
        turn.state = replace(turn.state, activity=AwaitingGap(answer, judged.plan, until))
        turn.note_verdict(judged.verdict)
        return turn.resting
    _note_refusal(turn, judged)
    if turn.may_repair():
        return None
    turn.failed()
    return turn.resting


def await_gap(turn: PendingTransition, held: AwaitingGap) -> Directive:
    """Check whether a plan that waits for a gap in the traffic can begin now."""
    guided = intent_authorizes(turn.state.reading, held.plan)
    judged = _admitted(turn, held.plan, guided=guided, approvals=_approvals(turn, held.plan), again=True)
    if judged is not None and judged.verdict.accepted:
        turn.tell_decision(held.answer, judged.verdict)
        return start(turn, judged, held.answer)
    if judged is None or not judged.passing or turn.is_blind or turn.now_s >= held.until_s:
        turn.state = replace(turn.state, activity=Monitoring())
        if judged is not None:
            _note_refusal(turn, judged)
    return turn.resting


def still_there(turn: PendingTransition) -> bool:
    """True if a plan given up right after its start waits for the next gap and the vehicle has not driven on."""
    held = turn.state.activity
    begun = held.from_m if isinstance(held, AwaitingGap) else None
    return begun is not None and turn.status.progress_m - begun < HARDLY_BEGUN_M


def aside(turn: PendingTransition) -> Admission | None:
    """Return the judged way to a better place to stand, or None if there is none or nothing is known."""
    view = turn.view
    behaviors: tuple[Behavior, ...] = ()
    if view is not None:
        behaviors = minimal_risk(turn.setup.guard, view, "").behaviors[:-1]
    if all(b.stands_still for b in behaviors):
        return None
    return _admitted(turn, RecoveryPlan(behaviors=behaviors), guided=False, approvals=NOBODY)


def may_stop(turn: PendingTransition) -> bool:
    """True if a stop here ends where the vehicle may stand, or if nothing is known of the place."""
    return turn.view is None or stops_where_one_may_stand(turn.setup.guard, turn.view)


def _admitted(
    turn: PendingTransition, plan: RecoveryPlan, *, guided: bool, approvals: Approvals, again: bool = False
) -> Admission | None:
    """Judge a plan and report the verdict. A plan that is judged again on every tick is reported only if accepted."""
    seen, view, now = turn.surroundings, turn.view, turn.now_s
    if seen is None or view is None:
        return None
    state = turn.state
    judged = admit(
        plan,
        view,
        now,
        guard=turn.setup.guard,
        scene=state.scene,
        history=state.history,
        guided=guided,
        approvals=approvals,
        again=again,
    )
    if judged.verdict.accepted or not again:
        turn.told.append(PlanReview(turn.stack_s, now, plan, seen, guided, approvals, judged.verdict))
    return judged


def _approvals(turn: PendingTransition, plan: RecoveryPlan) -> Approvals:
    """What people have approved for this plan, and what they have confirmed about the world."""
    under_way = turn.state.intervention
    agreed = NOBODY if under_way is None else under_way.approved.get(signature(plan), NOBODY)
    return union(agreed, as_guard_input(turn.state, turn.now_s))


def _note_refusal(turn: PendingTransition, judged: Admission) -> None:
    history = turn.state.history
    noted = history.with_attempt(judged.plan, AttemptOutcome.REJECTED, turn.stack_s, verdict=judged.verdict)
    turn.state = replace(turn.state, history=noted)
    turn.note_verdict(judged.verdict)


# ---- execution


def start(turn: PendingTransition, judged: Admission, answer: ReasonerAnswer | None = None) -> Directive:
    """Begin an accepted plan. `answer` is where it comes from; None for the way to the roadside."""
    state = turn.state
    words = None if state.words is None else state.words.words
    turn.state = replace(
        turn.state,
        activity=Executing(judged.execution, answer, words, turn.status.progress_m),
        escalation=state.escalation.note_accepted(),
        guidance_escalation=state.guidance_escalation.note_accepted(),
    )
    turn.note(lambda under_way: replace(under_way, done=None, helped=True))
    if state.standstill is None or not state.standstill.immovable:
        turn.withdraw_question()
    posture = state.posture
    if isinstance(posture, MinimalRisk):
        turn.state = replace(turn.state, posture=replace(posture, was=Driving()))
        release(turn, "a plan was accepted")
    else:
        turn.state = replace(turn.state, posture=Driving())
    turn.tell(EventKind.STARTED, ", ".join(b.name for b in judged.plan.behaviors))
    return perform(turn)


def perform(turn: PendingTransition) -> Directive:
    """Execute one tick of the running plan."""
    running = turn.state.activity
    assert isinstance(running, Executing)
    execution, result = _ticked(turn, running)
    if not isinstance(result, ExecutionOutcome):
        turn.state = replace(turn.state, activity=replace(running, execution=execution))
        return result
    turn.state = replace(turn.state, activity=Monitoring())
    _let_out(turn, running)
    stays = hand_back.after_plan(turn)
    kind = EventKind.FINISHED if result.finished else EventKind.ABORTED
    turn.tell(kind, result.text + (STANDS_THERE if stays else ""))
    if result.finished:
        return _finished(turn, running)
    return _given_up(turn, running, result, execution)


def _let_out(turn: PendingTransition, running: Executing) -> None:
    """If the plan that ends was to let somebody out and the vehicle stands, it stays until it is told to go."""
    reading = None if running.words is None else running.words.reading
    lets_out = reading is not None and reading.intent is GuidanceIntent.LET_ME_OUT
    if lets_out and turn.status.speed_mps < STOPPED_MPS:
        turn.state = replace(turn.state, letting_out=True)


def _ticked(turn: PendingTransition, running: Executing) -> tuple[Execution, Step | ExecutionOutcome]:
    """Return the plan after this tick, with the step to take or the outcome."""
    seen, view, now = turn.surroundings, turn.view, turn.now_s
    # A vehicle that is being led to a stop is not handed over before it stands.
    under_way = running.execution.is_stopping_blind and turn.status.speed_mps > STOPPED_MPS
    if seen is None or view is None or (turn.sight.blind_s > BLIND_LIMIT_S and not under_way):
        return running.execution, ExecutionOutcome(False, f"nothing has been seen for {BLIND_LIMIT_S:g} s")
    execution, result = running.execution.advance(view, now, turn.setup.ladder.asking.next_step_s)
    turn.told.append(ExecutionTick(turn.stack_s, now, seen, running.withdrawn, result, execution.last_verdict))
    return execution, result


def _finished(turn: PendingTransition, running: Executing) -> Directive:
    plan = running.execution.plan
    in_force, move = turn.state.words, turn.state.escalation.move
    if in_force is not None and running.words is in_force.words:
        end_words(turn, "done")
    turn.note(lambda under_way: replace(under_way, done=(plan, running.begun_m)))
    gap_m = hand_back.blocked_at_m(turn)
    if running.answer is None and isinstance(move, CallAssistance) and gap_m is not None and may_stop(turn):
        return stop_for_assistance(
            turn, move, gap_m
        )  # at once, because the stack would drive back to where it was blocked
    turn.state = replace(
        turn.state, escalation=turn.state.escalation.note_failure(turn.now_s), detector_ignored_until_s=turn.now_s
    )
    return Replan(route_start=plan.route_start) if plan.replan_route else CONTINUE


def _given_up(turn: PendingTransition, running: Executing, result: ExecutionOutcome, execution: Execution) -> Directive:
    plan, now, last = execution.plan, turn.now_s, execution.last_verdict
    text = f"aborted: {result.text}"
    history = turn.state.history
    history = history.with_attempt(plan, AttemptOutcome.ABORTED, turn.stack_s, text=text, verdict=result.verdict)
    if result.next_step is not None:
        history = history.half_done(plan, for_traffic=result.next_step is NextStep.TIMED_OUT)
    turn.state = replace(turn.state, history=history.aborted(plan, last))
    turn.note_verdict(result.verdict)
    passing = passes(last, frozenset()) and result.next_step is not NextStep.REFUSED
    turn.failed(counts=not passing)
    hardly_begun = turn.status.progress_m - running.begun_m < HARDLY_BEGUN_M and not execution.step_done
    if passing and hardly_begun and running.answer is not None and not running.withdrawn:
        until = now + turn.setup.ladder.asking.hold_s
        turn.state = replace(turn.state, activity=AwaitingGap(running.answer, plan, until, running.begun_m))
    return CONTINUE
