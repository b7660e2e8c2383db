"""The transition function: from a state and the inputs of a tick to the next state, a directive and events."""

from __future__ import annotations

import math
from dataclasses import replace

from stucksolver.immobilization import Trigger
from stucksolver.ladder import Ladder
from stucksolver.plan import CONTINUE, Directive
from stucksolver.solver.events import EventKind, StepOutput
from stucksolver.solver.recovery_watch import RecoveryWatch
from stucksolver.solver.state_machine import guidance, hand_back, immovable, plan_lifecycle, rung_dispatch, standstill
from stucksolver.solver.state_machine.escalation import Escalation, Rungs
from stucksolver.solver.state_machine.execution_steps import STAND
from stucksolver.solver.state_machine.history import AttemptHistory
from stucksolver.solver.state_machine.inputs import Inputs, SolverSetup
from stucksolver.solver.state_machine.pending_transition import PendingTransition
from stucksolver.solver.state_machine.state import (
    AwaitingGap,
    Executing,
    Holding,
    Intervention,
    MinimalRisk,
    Monitoring,
    Querying,
    State,
)

REFUSAL_M = 50.0
"""What a passenger refused is behind after this distance: about a braking distance and the length of a queue."""


def first_state(ladder: Ladder, reasoners: frozenset[str], *, observe_only: bool = False) -> State:
    """Return the state before the first tick.

    Args:
        ladder: The escalation policy.
        reasoners: Names of the reasoners present.
        observe_only: Judge plans, but never execute them.

    Raises:
        ValueError: No rung of the ladder can be used.
    """
    return State(
        escalation=Escalation(Rungs.of(ladder, reasoners, only_reasoners=observe_only)),
        guidance_escalation=Escalation(Rungs.of(ladder, reasoners, only_reasoners=True)),
        history=AttemptHistory(ladder.asking.remembered),
        progress=RecoveryWatch(ladder.hand_back.progress_m),
    )


def transition(state: State, inputs: Inputs, setup: SolverSetup) -> tuple[State, Directive, tuple[StepOutput, ...]]:
    """Compute one tick. The result depends only on the arguments, and none of them is changed.

    Args:
        state: The state after the last tick.
        inputs: The inputs of this tick.
        setup: The fixed parts of the solver.

    Returns:
        The next state, the directive for the stack, and the events in order. A `Querying` state with a new query asks
        the caller to start a reasoner; leaving that state without an answer asks it to drop the question.
    """
    turn = PendingTransition(state, inputs, setup)
    if inputs.jump_s is not None:
        turn.tell(EventKind.FAULT, f"the clock jumped by {inputs.jump_s:.2f} s")
    standstill.follow(turn)
    guidance.receive_guidance(turn)
    _watch(turn)
    directive = _act(turn)
    if directive == CONTINUE:
        directive = hand_back.stay(turn) if isinstance(turn.state.posture, Holding) else hand_back.watch(turn)
    if turn.state.letting_out and directive == CONTINUE:
        directive = STAND
    immovable.watch(turn, directive)
    standstill.inform(turn)
    turn.tell_fault(turn.state.senses_fault or turn.state.camera_fault)
    _settle(turn)
    return turn.state, directive, tuple(turn.told)


def _act(turn: PendingTransition) -> Directive:
    reply = turn.reply
    if reply is not None:
        turn.state = replace(turn.state, question=None)
    if isinstance(turn.state.activity, Executing):
        return plan_lifecycle.perform(turn)
    if reply is not None:
        return rung_dispatch.handle_reply(turn, reply)
    state = turn.state
    hand_back.end_stop(turn)
    state, stopped = turn.state, isinstance(turn.state.posture, MinimalRisk)
    if state.letting_out and state.words is None:
        return state.posture.directive
    if turn.inputs.trigger is None and state.words is None and not stopped and not plan_lifecycle.still_there(turn):
        rung_dispatch.close_questions(turn)
        return CONTINUE
    if isinstance(state.activity, Querying):
        return rung_dispatch.take_answer(turn)
    return rung_dispatch.next_step(turn)


def _watch(turn: PendingTransition) -> None:
    """Note the progress. A legitimate wait is not an immobilization; only an open intervention is."""
    _forget_refusal(turn)
    under_way = turn.state.intervention
    counted: Trigger | None = None if under_way is None else turn.inputs.trigger
    progress, recovered_after = turn.state.progress.advance(turn.status, turn.onset_s, counted)
    if recovered_after is not None and under_way is not None and _is_behind_blocker(turn, under_way):
        if isinstance(turn.state.activity, Executing):
            return  # the plan may be passing it
        turn.tell(EventKind.QUEUE_MOVED, "the blocker has moved on and is still ahead: failed plans stay in memory")
        turn.note(lambda under_way: replace(under_way, queue_moved=True))
        turn.state = replace(turn.state, progress=progress)
        return
    turn.state = replace(turn.state, progress=progress)
    if recovered_after is None or under_way is None:
        return
    if under_way.helped:
        far = turn.setup.ladder.hand_back.progress_m
        turn.tell(EventKind.RECOVERED, f"{far:g} m of new progress, {recovered_after:.1f} s after onset")
    turn.note(lambda under_way: replace(under_way, recovered=True, helped=False))


def _is_behind_blocker(turn: PendingTransition, under_way: Intervention) -> bool:
    """True if the object that the intervention began behind is seen to be still ahead in the path."""
    gone_m = turn.setup.ladder.hand_back.gone_m
    if under_way.blocker is None or gone_m <= 0.0 or turn.view is None or turn.is_blind:
        return False
    return under_way.blocker.is_ahead(turn.view, gone_m)


def _forget_refusal(turn: PendingTransition) -> None:
    """Forget what a passenger refused, or warned of, once it is behind the vehicle."""
    barred_m = turn.state.barred_m
    if barred_m is not None and turn.status.progress_m - barred_m > REFUSAL_M:
        turn.state = replace(turn.state, barred_m=None)
    escalation, declined_at_m = turn.state.escalation, turn.state.declined_at_m
    if escalation.quiet_until_s != math.inf:
        turn.state = replace(turn.state, declined_at_m=None)
        return
    declined_at_m = turn.status.progress_m if declined_at_m is None else declined_at_m
    turn.state = replace(turn.state, declined_at_m=declined_at_m)
    if turn.status.progress_m - declined_at_m > REFUSAL_M:
        turn.state = replace(turn.state, escalation=replace(escalation, quiet_until_s=turn.now_s), declined_at_m=None)


def _settle(turn: PendingTransition) -> None:
    """Reset the counters once the hand-back is verified or there is nothing left to do."""
    state = turn.state
    if state.intervention is None or not state.settled or turn.inputs.hearing:
        return
    recovered = state.intervention.recovered
    if not (recovered or not state.progress.active or turn.status.at_destination):
        return
    moved = state.intervention.queue_moved and not recovered
    history = AttemptHistory(state.history.remembered)
    if moved:
        history = replace(state.history, blocker=state.history.blocker or state.intervention.blocker)
    turn.tell(EventKind.CLOSED, "the vehicle is on its way" if recovered else "the queue moves" if moved else "done")
    if isinstance(state.activity, AwaitingGap):
        turn.state = replace(turn.state, activity=Monitoring())
    turn.state = replace(
        turn.state,
        intervention=None,
        escalation=state.escalation.reset(),
        history=history,
    )
