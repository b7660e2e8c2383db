"""Answers chat completions: finds the scene in the messages, asks the student, and writes its decision as a call.

If the client offers the function `check_plan`, the student calls it for the plans that it would propose, one a turn,
before it decides. Nothing is kept between requests: the verdicts are in the messages.

Every error is one of OpenAI's form, with a message that says what is wrong and what to do.
"""

from __future__ import annotations

import json
import time
import uuid
from dataclasses import dataclass
from types import NoneType
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from stucksolver.decision import Decision, RecoveryPlan
from stucksolver.decision.behaviors import Behavior
from stucksolver.reason.distilled import DistilledReasoner
from stucksolver.reason.distilled.scene_text import HEAD, SceneTextError, read_scene
from stucksolver.reason.llm.answer import AnswerError, parse_plan
from stucksolver.reason.llm.read_text import PromptError, read_prompt
from stucksolver.reason.llm.schema import CHECK_PLAN, DECIDE, MOST_CONTROLS, MOST_PARTICIPANTS, MOST_TEXT
from stucksolver.reason.reasoner import ACCEPTED, PlanCheck, ReasonerError, Request
from stucksolver.scene import Guidance, Scene
from stucksolver.words import WordsReader, situation_of

MODEL = "student"
READY = "ready"
"""The function with which our own client asks, before a drive, whether it is answered."""
MOST_MESSAGES = 64
CHARACTERS_FOR_A_TOKEN = 4


class RequestError(Exception):
    """A request that cannot be answered. `status` is that of HTTP; `field` names the part that is wrong, if any."""

    def __init__(self, message: str, *, field: str | None = None, code: str | None = None, status: int = 400) -> None:
        super().__init__(message)
        self.field, self.code, self.status = field, code, status

    @property
    def body(self) -> dict[str, Any]:
        """The error as OpenAI's API writes it."""
        kind = "invalid_request_error" if self.status < 500 else "server_error"
        return {"error": {"message": str(self), "type": kind, "param": self.field, "code": self.code}}


class _Tolerant(BaseModel):
    """What clients send beyond this is ignored."""

    model_config = ConfigDict(extra="ignore")


class Part(_Tolerant):
    """A part of a message's content. Images are not looked at."""

    type: str
    text: str = ""


class FunctionCalled(_Tolerant):
    """A function and its arguments, as JSON."""

    name: str
    arguments: str = ""


class ToolCalled(_Tolerant):
    """A call that we made before."""

    id: str
    function: FunctionCalled


class Turn(_Tolerant):
    """One message."""

    role: Literal["system", "developer", "user", "assistant", "tool", "function"]
    content: str | list[Part] | None = None
    tool_calls: list[ToolCalled] | None = None
    tool_call_id: str | None = None

    @property
    def text(self) -> str:
        """Its text without images."""
        if isinstance(self.content, list):
            return "\n".join(part.text for part in self.content if part.type == "text")
        return self.content or ""


class Function(_Tolerant):
    """A function that may be called."""

    name: str


class OfferedTool(_Tolerant):
    """A tool that may be used."""

    function: Function


class JsonSchema(_Tolerant):
    """The name of the form in which the answer is wanted."""

    name: str


class ResponseFormat(_Tolerant):
    """The form in which the answer is wanted."""

    type: str
    json_schema: JsonSchema | None = None


class Completion(_Tolerant):
    """A request for a chat completion."""

    model: str
    messages: list[Turn] = Field(min_length=1, max_length=MOST_MESSAGES)
    tools: list[OfferedTool] = Field(default_factory=list)
    tool_choice: str | OfferedTool | None = None
    response_format: ResponseFormat | None = None
    stream: bool = False


@dataclass(frozen=True)
class Student:
    """The student behind the API.

    Attributes:
        reasoner: Answers scenes.
        reader: Reads the passenger's words, since a prompt does not say how they were understood.
    """

    reasoner: DistilledReasoner
    reader: WordsReader

    def complete(self, body: bytes) -> dict[str, Any]:
        """Return the completion that answers a request.

        Args:
            body: The request's JSON.

        Raises:
            RequestError: It cannot be answered; nothing else is ever raised because of what it says.
        """
        asked = _parsed(body)
        if asked.stream:
            raise RequestError("streaming is not supported: send stream=false", field="stream")
        if asked.model not in (MODEL, self.reasoner.name):
            why = f"the model {asked.model!r} does not exist; this server has {MODEL!r}"
            raise RequestError(why, field="model", code="model_not_found", status=404)
        function = _function(asked)
        if function == READY:
            return _completion(asked, READY, {"ready": True})
        if function not in (None, DECIDE):
            raise RequestError(f"offer a function named {DECIDE!r}: {function!r} is not known", field="tools")
        scene = self._understood(_scene(asked))
        try:
            decision = self.reasoner.decide(Request(scene, guard_of(asked, scene))).decision
        except Unasked as question:
            return _completion(asked, CHECK_PLAN, {"behaviors": question.plan.model_dump(mode="json")["behaviors"]})
        except ReasonerError as error:
            raise RequestError(str(error), field="messages") from error
        return _completion(asked, DECIDE, answer_of(decision))

    def _understood(self, scene: Scene) -> Scene:
        words = scene.guidance
        if words is None or words.reading is not None:
            return scene
        reading = self.reader.read(words.text, situation_of(scene))
        told = Guidance(text=words.text, time_s=words.time_s, reading=reading)
        return scene.model_copy(update={"guidance": told})


class Unasked(Exception):
    """The guard's verdict on a plan is wanted before the student decides."""

    def __init__(self, plan: RecoveryPlan) -> None:
        super().__init__("a plan whose verdict is not known yet")
        self.plan = plan


def guard_of(asked: Completion, scene: Scene) -> PlanCheck | None:
    """Return the guard as the client has told and offers it: the verdicts in the messages, and the function
    `check_plan`. None if there is neither.

    The check raises `Unasked` while a plan has no verdict and one can be asked for. When the function is no longer
    offered, a plan without a verdict counts as accepted: whoever asks us has a guard that checks it.
    """
    told = verdicts(asked, scene)
    offered = isinstance(asked.tool_choice, (str, NoneType)) and any(
        tool.function.name == CHECK_PLAN for tool in asked.tools
    )
    if not told and not offered:
        return None

    def check(plan: RecoveryPlan) -> str:
        said = told.get(plan.behaviors)
        if said is None and offered:
            raise Unasked(plan)
        return ACCEPTED if said is None else said

    return check


def verdicts(asked: Completion, scene: Scene) -> dict[tuple[Behavior, ...], str]:
    """Return what the guard said to the plans about which it was asked in these messages."""
    calls = {call.id: call.function for turn in asked.messages for call in turn.tool_calls or ()}
    found: dict[tuple[Behavior, ...], str] = {}
    for turn in asked.messages:
        call = calls.get(turn.tool_call_id or "")
        if turn.role != "tool" or call is None or call.name != CHECK_PLAN:
            continue
        try:
            found[parse_plan(call.arguments, scene).behaviors] = turn.text
        except AnswerError as error:
            raise RequestError(f"a call of {CHECK_PLAN} holds no plan: {error}", field="messages") from error
    return found


def _parsed(body: bytes) -> Completion:
    try:
        return Completion.model_validate_json(body)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or None
        raise RequestError(f"{where or 'the body'}: {first['msg']}", field=where) from error


def _function(asked: Completion) -> str | None:
    """Return the name of the function or form in which the answer is wanted; None for a text."""
    if isinstance(asked.tool_choice, OfferedTool):
        return asked.tool_choice.function.name
    names = [tool.function.name for tool in asked.tools]
    if DECIDE in names:
        return DECIDE
    if names:
        return names[0]
    form = asked.response_format
    return None if form is None or form.json_schema is None else form.json_schema.name


def _scene(asked: Completion) -> Scene:
    """Return the scene of the last message from the user that has one: later ones may ask for a repair."""
    wrong: str | None = None
    for turn in reversed(asked.messages):
        if turn.role != "user":
            continue
        text = turn.text
        try:
            return read_scene(text) if text.startswith(HEAD) else read_prompt(text)
        except (PromptError, SceneTextError) as error:
            wrong = str(error)
    raise RequestError(
        f"no message of the user is a scene ({wrong or 'there is none'}); send what `stucksolver prompt` prints",
        field="messages",
    )


def answer_of(decision: Decision) -> dict[str, Any]:
    """Return a decision as the arguments of the function `decide`."""
    said, thought, plan = decision.observation, decision.analysis, decision.plan
    data = decision.model_dump(mode="json")
    return {
        "observation": {
            "controls": [
                {"kind": c.kind.value, "state": None if c.state is None else c.state.value, "applies": c.applies}
                for c in said.controls[:MOST_CONTROLS]
            ],
            "participants": [
                {"object_id": p.object_id, "kind": p.kind.value, "lane": p.lane.value, "intent": p.intent.value}
                for p in said.participants[:MOST_PARTICIPANTS]
            ],
            "summary": said.summary[:MOST_TEXT],
        },
        "analysis": {
            "steps": {one.id: {"answer": one.answer, "evidence": one.evidence[:MOST_TEXT]} for one in thought.steps},
            **{name: data["analysis"][name] for name in ("immobilized", "cause", "wait", "guidance_intent")},
            "reason": thought.reason[:MOST_TEXT],
        },
        "decision": {
            "rationale": decision.rationale[:MOST_TEXT],
            "behaviors": None if plan is None else data["plan"]["behaviors"],
            "replan_route": plan is not None and plan.replan_route,
            "route_start": None if plan is None else plan.route_start,
        },
    }


def _completion(asked: Completion, function: str, arguments: dict[str, Any]) -> dict[str, Any]:
    """Return an answer as a call if tools were offered, else as the text of the message."""
    text = json.dumps(arguments)
    message: dict[str, Any] = {"role": "assistant", "content": text, "refusal": None}
    if asked.tools:
        call = {"id": f"call_{uuid.uuid4().hex[:24]}", "type": "function"}
        message |= {"content": None, "tool_calls": [call | {"function": {"name": function, "arguments": text}}]}
    told = sum(len(turn.text) for turn in asked.messages)
    spent = told // CHARACTERS_FOR_A_TOKEN, len(text) // CHARACTERS_FOR_A_TOKEN
    return {
        "id": f"chatcmpl-{uuid.uuid4().hex[:24]}",
        "object": "chat.completion",
        "created": int(time.time()),
        "model": asked.model,
        "choices": [
            {
                "index": 0,
                "message": message,
                "logprobs": None,
                "finish_reason": "tool_calls" if asked.tools else "stop",
            }
        ],
        "usage": {"prompt_tokens": spent[0], "completion_tokens": spent[1], "total_tokens": sum(spent)},
    }


__all__ = ["MODEL", "RequestError", "Student", "answer_of"]
