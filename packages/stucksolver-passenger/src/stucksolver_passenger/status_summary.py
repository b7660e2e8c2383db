"""Describes the car's situation and next action in two sentences made from its typed state. No text is parsed."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.ladder import CallAssistance, Resume
from stucksolver.plan import Decision, RecoveryPlan
from stucksolver.scene import IMMOBILIZED_BELOW_MPS, ControlKind, LightState, Scene, Status
from stucksolver.solver import Event, QuestionKind
from stucksolver.solver.state_machine.state import AwaitingApproval, AwaitingGap, Executing, State, StateName
from stucksolver_passenger.sentences.nouns import nouns
from stucksolver_passenger.sentences.plans import future_phrase, present_phrase
from stucksolver_passenger.sentences.reasons import IMMOVABLE, blocked_by, waiting
from stucksolver_passenger.sentences.rejections import rejection_sentence

FRESH_S = 4.0
"""Time for which a decision about a stopped car is its displayed thought (s). It is renewed every few seconds. Ours."""
NEAR_M, LIGHT_M = 45.0, 60.0
"""Distances within which a road user and a red light are mentioned (m). Ours."""
MOVING_MPS = 0.5
"""Speed from which a vehicle counts as moving (m/s). Ours."""
STATES: dict[StateName, str] = {
    StateName.MONITORING: "I am watching the road.",
    StateName.QUERYING: "I am working out how to go on.",
    StateName.AWAITING_APPROVAL: "I need a yes before I go on.",
    StateName.AWAITING_GAP: "I am waiting for a gap in the traffic.",
    StateName.EXECUTING: "I am on my way round it.",
    StateName.DRIVING: "I am driving along our route.",
    StateName.HOLDING: "I am waiting until the way back into my lane is free.",
    StateName.MINIMAL_RISK: "I have stopped and called the operator.",
}
"""Meaning of each of the solver's states for a passenger, unless more specific information exists."""


@dataclass(frozen=True)
class StatusSummary:
    """Two sentences: the current situation, and the next action."""

    thought: str
    intention: str


OVER = StatusSummary("The ride is over.", "Thank you for riding with me.")


def mind(state: State, status: Status, decided: Event | None, scene: Scene | None) -> StatusSummary:
    """Return the sentences for people about a solver's state.

    Args:
        state: The solver's state.
        status: The vehicle's status.
        decided: The last decision event; None before the first.
        scene: The newest scene, if any.
    """
    activity = state.activity
    if state.standstill is not None and state.standstill.immovable:
        return StatusSummary(IMMOVABLE, "I have told the operator.")
    if isinstance(activity, Executing):
        return _executing(activity)
    if state.posture.name is not StateName.DRIVING:
        return _standing(state)
    question = state.question
    if isinstance(activity, AwaitingApproval) and question is not None:
        addressee = "you" if question.to == "passenger" else "the operator"
        return StatusSummary(_why(activity.answer.decision, scene), f"I am waiting for an answer from {addressee}.")
    if isinstance(activity, AwaitingGap):
        return StatusSummary(_why(activity.answer.decision, scene), f"I will {future_phrase(activity.plan)}.")
    if question is not None and question.kind is QuestionKind.ADVICE:
        return StatusSummary(_decided_thought(decided, scene), "I am waiting for your advice.")
    if state.escalation.quiet_until_s > status.time_s and _is_slow(status, scene):
        return StatusSummary(
            _ahead(scene) or "I am standing.", "I am waiting, as you asked. Tell me when I should try again."
        )
    fresh = decided is not None and status.time_s - decided.time_s < FRESH_S
    if decided is not None and fresh and _is_slow(status, scene):
        return _decided(decided, scene)
    return _driving(status, scene)


def _executing(activity: Executing) -> StatusSummary:
    if activity.withdrawn:
        return StatusSummary(
            "I am ending this as soon as that is safe.", "Where a stop would not be safe, I finish first."
        )
    plan = activity.execution.plan
    moving = [behavior for behavior in plan.behaviors if not behavior.stands_still]
    return StatusSummary(present_phrase((moving or list(plan.behaviors))[0]), "Then I will drive on along our route.")


def _standing(state: State) -> StatusSummary:
    thought = STATES[state.posture.name]
    if state.posture.name is StateName.HOLDING:
        return StatusSummary(thought, "Then I will drive on.")
    move = state.escalation.move
    only_operator = isinstance(move, CallAssistance) and move.resume is Resume.OPERATOR
    return StatusSummary(
        thought, "The operator decides how we go on." if only_operator else "I will go on when the way is free."
    )


def _why(decision: Decision, scene: Scene | None) -> str:
    analysis = decision.analysis
    if analysis.wait is not None:
        return waiting(analysis.wait, scene)[0]
    # A request can exist without an obstacle.
    return blocked_by(analysis.cause, scene) if analysis.cause else _ahead(scene) or blocked_by(None, scene)


def _ahead(scene: Scene | None) -> str | None:
    """Return a sentence about the road users ahead; None if none is near."""
    ahead = () if scene is None else scene.in_path_ahead(NEAR_M)
    if not ahead:
        return None
    group = [o.kind for o in ahead if abs(o.speed_along_mps - ahead[0].speed_along_mps) < 1.0]
    named = nouns(group)
    if ahead[0].speed_along_mps > MOVING_MPS:
        return f"I am driving behind {named}."
    return f"There {'is' if named == nouns(group[:1]) else 'are'} {named} ahead of me."


def _decided_thought(decided: Event | None, scene: Scene | None) -> str:
    if decided is None or decided.decision is None:
        return blocked_by(None, scene)
    return _why(decided.decision, scene)


def _decided(event: Event, scene: Scene | None) -> StatusSummary:
    decision = event.decision
    if decision is None:
        return StatusSummary(STATES[StateName.QUERYING], "I will tell you what I find.")
    if decision.analysis.wait is not None and decision.plan is None:
        return StatusSummary(*waiting(decision.analysis.wait, scene))
    if event.verdict is not None and not event.verdict.accepted:
        return StatusSummary(_why(decision, scene), rejection_sentence(event.verdict, event.scene or scene))
    return StatusSummary(_why(decision, scene), _planned(decision.plan))


def _planned(plan: RecoveryPlan | None) -> str:
    return "I will keep looking for a way." if plan is None else f"I will {future_phrase(plan)}."


def _is_slow(status: Status, scene: Scene | None) -> bool:
    """Return True if the car is slower than the detector's threshold."""
    return status.speed_mps < (IMMOBILIZED_BELOW_MPS if scene is None else scene.ego.immobilized_below_mps)


def _driving(status: Status, scene: Scene | None) -> StatusSummary:
    if status.at_destination:
        return StatusSummary("We are there.", "I will stop here.")
    moving = not _is_slow(status, scene)
    if scene is not None:
        lights = [c for c in scene.controls if c.kind is ControlKind.TRAFFIC_LIGHT and c.applies is not False]
        if any(c.state is LightState.RED and 0.0 < c.distance_m < LIGHT_M for c in lights):
            return StatusSummary("The light ahead is red.", "I will stop there and wait for green.")
        here = _ahead(scene)
        if here is not None:
            return StatusSummary(here, _about(scene.in_path_ahead(NEAR_M)[0].speed_along_mps > MOVING_MPS, moving))
    if not moving:
        return StatusSummary("I am standing.", "I will drive on when the way is free.")
    return StatusSummary(STATES[StateName.DRIVING], "I will follow our route.")


def _about(leader_moves: bool, moving: bool) -> str:
    """Return what the car will do about the road user ahead."""
    if leader_moves:
        return "I am staying behind, unless you ask me to overtake."
    if moving:
        return "I will slow down and see whether I can get past."
    return "I am checking whether I can get past."
