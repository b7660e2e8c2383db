"""Short queries before a drive: checks that the server responds, and that it keeps to the schema of a decision.

The queries have the real schema and a short limit of tokens, and their words ask for something else than the schema. So
an answer that follows the schema proves that the server enforces it, and the schema is compiled before the first query
of the drive.
"""

from __future__ import annotations

import time
from typing import Protocol, runtime_checkable

from stucksolver.scene import CameraImage
from stucksolver_language.llm.answer_form import USUAL_FORM, AnswerForm
from stucksolver_language.llm.capabilities import ServerCapabilities
from stucksolver_language.llm.chat import (
    ChatModel,
    ChatReply,
    Message,
    PermanentReasonerError,
    Tool,
    TransientKind,
    TransientReasonerError,
)
from stucksolver_language.llm.dialects import Dialect
from stucksolver_language.llm.reply_selection import follows_schema, only_thought
from stucksolver_language.llm.sdk_errors import LARGER_CONTEXT
from stucksolver_language.llm.server_memory import publish
from stucksolver_language.llm.tool_schema import full_decide_tool
from stucksolver_language.llm.waiting_notes import WaitingNotes

LIMIT_S = 120.0
"""Time limit of the preflight (s). A private server may have to load its model first. Ours."""
LIST_LIMIT_S = 5.0
"""Time limit of the query for the list of models, which only adds notes (s). Ours."""
BUSY_PAUSE_S = 2.0
"""Shortest pause before a busy server is queried again (s). Ours."""
PROBE_TOKENS = 32
"""Limit of an answer (tokens). The first key of the schema takes four; some providers refuse a limit below 16. Ours."""
PROMPT_TOKENS, SCHEMA_TOKENS = 3_300, 3_500
"""Upper bounds on the tokens of the messages and of the schema, which some dialects put into the prompt.

Measured with SmolLM2's encoding: 3,260 for 20 objects, a menu of three plans and three failed plans, and 3,463.
"""
CONTEXT_FIELDS = ("max_model_len", "context_length", "context_window", "n_ctx")
"""Fields that state the context in lists of models: vLLM, OpenRouter, Groq, llama.cpp (under `meta`)."""
SYSTEM = "You are asked whether you can be reached. Answer with the one word READY and nothing else."
GRAY_JPEG = (
    b"/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDACgcHiMeGSgjISMtKygwPGRBPDc3PHtYXUlkkYCZlo+AjIqgtObDoKrarYqMyP/L2u71"
    b"////m8H////6/+b9//j/wAALCABAAEABAREA/8QAFAABAAAAAAAAAAAAAAAAAAAAAP/EABQQAQAAAAAAAAAAAAAAAAAAAAD/2gAI"
    b"AQEAAD8AAAAAAAAAAAAAAAAAAAAAAP/Z"
)
"""64 x 64 gray pixels in base64."""


@runtime_checkable
class _Described(ChatModel, Protocol):
    takes: ServerCapabilities

    def described(self, limit_s: float) -> dict[str, object]: ...

    def probe(self, messages: list[Message], tool: Tool, most_tokens: int, limit_s: float) -> ChatReply: ...


def preflight_model(model: ChatModel, limit_s: float = LIMIT_S, form: AnswerForm = USUAL_FORM) -> tuple[str, ...]:
    """Send a model short queries and return the notes about missing features, one line each.

    `form` is the form of the answers, so that the schema of the drive is compiled. A line on standard error says what
    is waited for, if that takes longer than 10 s.

    Raises:
        PermanentReasonerError: Queries would fail.
    """
    model = getattr(model, "inner", model)
    if not isinstance(model, _Described):
        return ()
    ends_at = time.monotonic() + limit_s
    with WaitingNotes(model.name, limit_s) as waiting:
        waiting.begin("a short query with the schema of a decision")
        reply = _prove_schema(model, form, ends_at)
        if model.takes.pictures and reply.saw:
            waiting.begin("a short query without a picture")
            _prove_pictures(model, form, reply, ends_at)
        waiting.begin("its list of models")
        described = model.described(max(min(ends_at - time.monotonic(), LIST_LIMIT_S), 1.0))
    publish()
    notes = [f"{model.name} {note}" for note in model.takes.notes]
    _check_context(model.name, model.takes, context_of(described))
    if described.get("owned_by") == "library":
        notes.append(
            f"{model.name}: Ollama has 4,096 tokens of context unless OLLAMA_CONTEXT_LENGTH sets another value"
        )
    return tuple(notes)


def _prove_schema(model: _Described, form: AnswerForm, ends_at: float) -> ChatReply:
    """Find the first dialect in which the server keeps to the schema, and return its reply."""
    takes = model.takes
    while True:
        reply = _probed(model, form, True, ends_at)
        if takes.dialect is Dialect.PROSE or follows_schema(reply):
            return reply
        if only_thought(reply):
            # It thinks first, so that nothing is proven. A function call that was cut off looks the same.
            if reply.thoughts or reply.text or takes.dialect is Dialect.JSON_SCHEMA:
                takes.make_room(PROBE_TOKENS)
            return reply
        if not takes.step_down(f"answered without a call or the schema: {reply.text[:60]!r}"):
            return reply


def _prove_pictures(model: _Described, form: AnswerForm, seen: ChatReply, ends_at: float) -> None:
    """Send no more pictures if the server counts as many tokens without one: it has dropped the picture silently."""
    if seen.usage is None or seen.usage.input_tokens == 0:
        return
    blind = _probed(model, form, False, ends_at)
    if blind.usage is not None and blind.usage.input_tokens >= seen.usage.input_tokens:
        model.takes.omit_pictures(f"a query with a picture takes as many tokens as without ({seen.usage.input_tokens})")


def _probed(model: _Described, form: AnswerForm, picture: bool, ends_at: float) -> ChatReply:
    """Return the reply to a short query. A busy server is queried again.

    Raises:
        PermanentReasonerError: Queries would fail.
    """
    image = CameraImage(width=64, height=64, jpeg=GRAY_JPEG) if picture else None
    turns = [Message("system", SYSTEM), Message("user", "Ready?", image=image)]
    while True:
        reply, wait_s = _reply_or_wait(model, turns, full_decide_tool(form), ends_at)
        if reply is not None:
            return reply
        time.sleep(wait_s)


def _reply_or_wait(
    model: _Described, turns: list[Message], tool: Tool, ends_at: float
) -> tuple[ChatReply | None, float]:
    """Return the reply, or the time to wait for a busy server (s). Raises as `_probed`."""
    try:
        return model.probe(turns, tool, PROBE_TOKENS, ends_at - time.monotonic()), 0.0
    except TransientReasonerError as error:
        wait_s = max(error.after_s or 0.0, BUSY_PAUSE_S)
        if error.trouble is not TransientKind.BUSY or time.monotonic() + wait_s > ends_at:
            raise PermanentReasonerError(str(error)) from error
        return None, wait_s


def context_of(described: dict[str, object]) -> int | None:
    """Return the context (tokens) stated by an entry in a server's list of models, or None."""
    meta = described.get("meta")
    places = [described, meta if isinstance(meta, dict) else {}]
    stated = [place.get(field) for place in places for field in CONTEXT_FIELDS]
    return next((count for count in stated if isinstance(count, int) and count > 0), None)


def _check_context(name: str, takes: ServerCapabilities, context: int | None) -> None:
    """Check that a long query and its answer fit into the context.

    Raises:
        PermanentReasonerError: They do not fit.
    """
    schema = 0 if takes.dialect is Dialect.JSON_SCHEMA else SCHEMA_TOKENS
    needed = PROMPT_TOKENS + schema + takes.most_tokens
    if context is not None and context < needed:
        raise PermanentReasonerError(
            f"context too small: {name} has {context} tokens, a query and its answer need up to {needed}. "
            f"Start its server with more ({LARGER_CONTEXT}), or limit the answer with #tokens=N"
        )
