"""Converts states and inputs to JSON values and back: everything from which a step of the solver is replayed."""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from pydantic import TypeAdapter

from stucksolver.guard import Approvals
from stucksolver.immobilization import Trigger
from stucksolver.ladder import Ladder
from stucksolver.ladder.waits import NEVER_LONG
from stucksolver.plan import Decision, RecoveryPlan, WaitReason
from stucksolver.reasoners import ReasonerAnswer, ReasonerTrace
from stucksolver.scene import Claim, FailedAttempt, Guidance, Scene, Status, Surroundings
from stucksolver.solver.events import Event, PlanReview, StepOutput
from stucksolver.solver.notices import StandstillReason
from stucksolver.solver.query import NoAnswer
from stucksolver.solver.questions import PersonReply, Question
from stucksolver.solver.state_machine.blockers import Blocker
from stucksolver.solver.state_machine.escalation import Escalation
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from stucksolver.solver.state_machine.history import AttemptHistory
from stucksolver.solver.state_machine.inputs import GuidanceInput, Inputs, SceneInput, SurroundingsInput
from stucksolver.solver.state_machine.state import ActiveGuidance, Querying, Standstill, State
from stucksolver.solver.state_machine.transition import first_state
from stucksolver.solver.step_listener import TransitionStep

Data = dict[str, Any]
APPROVALS: TypeAdapter[Approvals] = TypeAdapter(Approvals)
STANDSTILL: TypeAdapter[Standstill] = TypeAdapter(Standstill)
BLOCKER: TypeAdapter[Blocker] = TypeAdapter(Blocker)
NOT_LOOKED = "the record does not contain this input"
"""Fault of an input that the recorded step did not use."""
SIMPLE = (
    "question_since_s",
    "questions",
    "queries",
    "clarification_asked",
    "interventions",
    "declined_at_m",
    "detector_ignored_until_s",
    "senses_fault",
    "camera_fault",
    "reported_fault",
)
"""Fields of a state that need no conversion to JSON."""
FORMER_NAMES = {
    "asked_back": "clarification_asked",
    "refused_m": "declined_at_m",
    "afresh_s": "detector_ignored_until_s",
    "told_fault": "reported_fault",
    "words_escalation": "guidance_escalation",
}
"""Present names of fields, by their names in records of earlier versions."""
SELDOM: Data = {"barred_m": None, "stop_said_s": None, "letting_out": False, "notices": 0}
"""Fields of that kind that are omitted if they have these values."""

FORMER_LADDER: Data = {
    "hand_back": {"gone_m": 0.0},
    "asking": {"next_step_s": 120.0},
    "tell": {"passenger_s": NEVER_LONG, "operator_s": NEVER_LONG, "light_s": 180.0},
    "standoff": {"back_off_s": 0.0},
}
"""Settings with the behavior of earlier versions, for records whose ladder does not have them."""


def complete_ladder(data: Data) -> Data:
    """Return the JSON form of a record's ladder with the settings that its version did not have yet."""
    return data | {table: former | data.get(table, {}) for table, former in FORMER_LADDER.items()}


def finite(value: float | None) -> float | str | None:
    """Convert a float; JSON has no infinity."""
    return str(value) if value is not None and math.isinf(value) else value


def of_finite(value: float | str | None) -> float:
    """Return the inverse of `finite`.

    Raises:
        ValueError: The value is not a number.
        TypeError: The value has the wrong type.
    """
    return float(value)  # type: ignore[arg-type]


# ---- the state at the start of a record


def state_data(state: State) -> Data:
    """Return an idle state, as at the beginning of a record: without an intervention, a question or a plan."""
    data = {name: getattr(state, name) for name in SIMPLE}
    data["escalation"] = _escalation(state.escalation)
    data["guidance_escalation"] = _escalation(state.guidance_escalation)
    data["onset"] = None if state.progress.onset is None else [finite(x) for x in state.progress.onset]
    data["trigger"] = None if state.trigger is None else state.trigger.value
    if state.words is not None:
        data["words"] = {"said": state.words.words.model_dump(mode="json"), "since_s": state.words.since_s}
    data |= {name: getattr(state, name) for name, usual in SELDOM.items() if getattr(state, name) != usual}
    if state.claims:
        data["claims"] = {claim.value: until_s for claim, until_s in state.claims.items()}
    if state.doubts:
        data["doubts"] = dict(state.doubts)
    if state.standstill is not None:
        data["standstill"] = STANDSTILL.dump_python(state.standstill, mode="json")
    if state.history != AttemptHistory(state.history.remembered):
        data["history"] = _history(state.history)
    return data


def state_of(data: Data, ladder: Ladder, reasoners: frozenset[str], *, observe_only: bool) -> State:
    """Return the inverse of `state_data`.

    Raises:
        KeyError: A field is missing.
        TypeError: A value has the wrong type.
        ValueError: A value is invalid.
    """
    first = first_state(ladder, reasoners, observe_only=observe_only)
    data = {FORMER_NAMES.get(name, name): value for name, value in data.items()}
    onset, words, trigger = data["onset"], data.get("words"), data["trigger"]
    if onset is not None:
        began_s, began_m = map(of_finite, onset)
        first = replace(first, progress=type(first.progress)(first.progress.recovered_m, (began_s, began_m)))
    if words is not None:
        first = replace(first, words=ActiveGuidance(Guidance.model_validate(words["said"]), words["since_s"]))
    seldom: Data = {name: data.get(name, usual) for name, usual in SELDOM.items()}
    return replace(
        first,
        escalation=_escalation_of(first.escalation, data["escalation"]),
        guidance_escalation=_escalation_of(first.guidance_escalation, data["guidance_escalation"]),
        trigger=None if trigger is None else Trigger(trigger),
        doubts=MappingProxyType(dict(data.get("doubts", {}))),
        standstill=None if data.get("standstill") is None else STANDSTILL.validate_python(data["standstill"]),
        history=_history_of(first.history, data.get("history")),
        claims=MappingProxyType({Claim(name): until_s for name, until_s in data.get("claims", {}).items()}),
        **{name: data[name] for name in SIMPLE},
        **seldom,
    )


def _history(history: AttemptHistory) -> Data:
    return {
        "attempts": [attempt.model_dump(mode="json") for attempt in history.attempts],
        "barred": [[key, why] for key, why in history.barred.items()],
        "halves": [plan.model_dump(mode="json") for plan in history.halves],
        "reason": None if history.reason is None else history.reason.model_dump(mode="json"),
        "blocker": None if history.blocker is None else BLOCKER.dump_python(history.blocker, mode="json"),
    }


def _history_of(first: AttemptHistory, data: Data | None) -> AttemptHistory:
    if data is None:
        return first
    barred = {tuple(tuple(part) for part in key): why for key, why in data["barred"]}
    return replace(
        first,
        attempts=tuple(FailedAttempt.model_validate(attempt) for attempt in data["attempts"]),
        barred=MappingProxyType(barred),
        halves=tuple(RecoveryPlan.model_validate(plan) for plan in data["halves"]),
        reason=None if data["reason"] is None else StandstillReason.model_validate(data["reason"]),
        blocker=None if data["blocker"] is None else BLOCKER.validate_python(data["blocker"]),
    )


def _escalation(escalation: Escalation) -> Data:
    return {
        "index": escalation.index,
        "tries": escalation.tries,
        "repairs": escalation.repairs,
        "not_before_s": finite(escalation.not_before_s),
        "quiet_until_s": finite(escalation.quiet_until_s),
        "since_s": finite(escalation.since_s),
        "waiting": {reason.value: since for reason, since in escalation.waiting.items()},
        "last_wait_s": escalation.last_wait_s,
    }


def _escalation_of(first: Escalation, data: Data) -> Escalation:
    return Escalation(
        first.on,
        data["index"],
        data["tries"],
        data["repairs"],
        of_finite(data["not_before_s"]),
        of_finite(data["quiet_until_s"]),
        of_finite(data["since_s"]),
        MappingProxyType({WaitReason(reason): since for reason, since in data["waiting"].items()}),
        data["last_wait_s"],
    )


# ---- the inputs of a step


def inputs_data(inputs: Inputs, answer: ReasonerAnswer | NoAnswer | None) -> Data:
    """Return the inputs that differ from their defaults, without the surroundings and the scene.

    `answer` is the reasoner's answer, if this step used one.
    """
    data: Data = {"status": inputs.status.model_dump(mode="json", exclude_defaults=True)}
    for name in ("slow_since_s", "progress_in_window_m", "jump_s"):
        value = getattr(inputs, name)
        if value is not None:
            data[name] = value
    if inputs.offset_s:
        data["offset_s"] = inputs.offset_s
    if inputs.trigger is not None:
        data["trigger"] = inputs.trigger.value
    if inputs.heard is not None:
        data["heard"] = {"words": inputs.heard.words.model_dump(mode="json"), "fault": inputs.heard.fault}
    if inputs.hearing:
        data["hearing"] = True
    if inputs.reply is not None:
        data["reply"] = {"yes": inputs.reply.yes, "by": inputs.reply.by}
    if isinstance(answer, NoAnswer):
        data["answer"] = {"why": answer.why, **({"malformed": True} if answer.malformed else {})}
    elif answer is not None:
        trace = None if answer.trace is None else answer.trace.model_dump(mode="json", exclude_none=True)
        decision = answer.decision.model_dump(mode="json")
        data["answer"] = {"reasoner": answer.reasoner, "decision": decision, "trace": trace}
    if inputs.busy:
        data["busy"] = sorted(inputs.busy)
    return data


def inputs_of(data: Data, sight: SurroundingsInput, snapshot: SceneInput, question: Question | None) -> Inputs:
    """Return the inverse of `inputs_data`; `question` is the open question.

    Raises:
        KeyError: A field is missing.
        TypeError: A value has the wrong type.
        ValueError: A value is invalid.
    """
    heard, reply, answer = data.get("heard"), data.get("reply"), data.get("answer")
    if reply is not None and question is None:
        raise ValueError("the reply belongs to no open question")
    return Inputs(
        status=Status.model_validate(data["status"]),
        look=lambda: sight,
        scene=lambda: snapshot,
        trigger=Trigger(data["trigger"]) if "trigger" in data else None,
        slow_since_s=data.get("slow_since_s"),
        progress_in_window_m=data.get("progress_in_window_m"),
        offset_s=data.get("offset_s", 0.0),
        jump_s=data.get("jump_s"),
        heard=None if heard is None else GuidanceInput(Guidance.model_validate(heard["words"]), heard["fault"]),
        hearing=data.get("hearing", False),
        reply=None if reply is None or question is None else PersonReply(question, reply["yes"], reply["by"]),
        answer=_answer_of(answer),
        busy=frozenset(data.get("busy", ())),
    )


def _answer_of(data: Data | None) -> ReasonerAnswer | NoAnswer | None:
    if data is None:
        return None
    if "why" in data:
        return NoAnswer(data["why"], data.get("malformed", False))
    trace = None if data["trace"] is None else ReasonerTrace.model_validate(data["trace"])
    return ReasonerAnswer(Decision.model_validate(data["decision"]), data["reasoner"], trace)


def sight_of(data: Data | None, seen: Surroundings | None) -> SurroundingsInput:
    """Return the recorded surroundings. A step that read none has none, and must not read any in the replay either."""
    return (
        SurroundingsInput(None, NOT_LOOKED, math.inf)
        if data is None
        else SurroundingsInput(seen, data["fault"], of_finite(data["blind_s"]))
    )


def snapshot_of(data: Data | None) -> SceneInput:
    """Return the recorded scene in the same way."""
    if data is None:
        return SceneInput(None, NOT_LOOKED)
    scene = None if data["scene"] is None else Scene.model_validate(data["scene"])
    return SceneInput(scene, data["why_none"], data["camera_fault"])


# ---- the events of a step


def accepted_answer(step: TransitionStep) -> ReasonerAnswer | NoAnswer | None:
    """Return the reasoner's answer, if this step acted on it."""
    activity = step.before.activity
    used = isinstance(activity, Querying) and step.after.activity is not activity
    return step.inputs.answer if used else None


def step_output_data(output: StepOutput, step: TransitionStep) -> Data:
    """Return an event, a plan review or a tick of a running plan. The step stores surroundings and directive."""
    if isinstance(output, Event):
        return {"event": event_data(output, accepted_answer(step))}
    verdict = output.verdict.model_dump(mode="json", exclude_defaults=True)
    if isinstance(output, PlanReview):
        kinds = APPROVALS.dump_python(output.approvals, mode="json").items()
        approvals = {kind: sorted(names) for kind, names in kinds if names or kind != "barred"}
        plan = output.plan.model_dump(mode="json")
        return {"judged": {"plan": plan, "guided": output.guided, "approvals": approvals, "verdict": verdict}}
    data: Data = {} if output.verdict.accepted else {"verdict": verdict}
    if output.withdrawn:
        data["withdrawn"] = True
    if isinstance(output.result, ExecutionOutcome):
        data["outcome"] = output.result.recorded()
    elif output.result is not step.directive:
        data["directive"] = output.result.model_dump(mode="json")
    return {"tick": data}


def event_data(event: Event, answer: ReasonerAnswer | NoAnswer | None) -> Data:
    """Return an event without its scene, stored with the query, and without a decision that is among the inputs."""
    is_input = isinstance(answer, ReasonerAnswer) and event.decision is answer.decision
    stored_before = {"scene", "decision", "trace"} if is_input else {"scene"}
    data = event.model_dump(mode="json", exclude_none=True, exclude=stored_before)
    return {key: value for key, value in data.items() if value is not False or key == "answer"}
