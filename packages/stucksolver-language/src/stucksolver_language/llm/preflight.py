"""One short query before a drive: checks that the server responds and accepts the key and the model.

It also discovers the features that the server lacks, so that the first real query loses no time.
"""

from __future__ import annotations

import time
from typing import Protocol, runtime_checkable

from stucksolver.scene import CameraImage
from stucksolver_language.llm.capabilities import ServerCapabilities
from stucksolver_language.llm.chat import (
    ChatModel,
    Message,
    PermanentReasonerError,
    Tool,
    TransientKind,
    TransientReasonerError,
)
from stucksolver_language.llm.dialects import Dialect
from stucksolver_language.llm.sdk_errors import LARGER_CONTEXT
from stucksolver_language.llm.server_memory import publish

LIMIT_S = 120.0
"""Time limit of the preflight (s). A private server may have to load its model first. Ours."""
BUSY_PAUSE_S = 2.0
"""Shortest pause before a busy server is queried again (s). Ours."""
PROMPT_TOKENS, SCHEMA_TOKENS = 2_100, 2_600
"""Upper bounds on the tokens of the messages and of the schema, which some dialects put into the prompt.

`MOST_CHARACTERS` of the scene's text follows from the first.
"""
CONTEXT_FIELDS = ("max_model_len", "context_length", "context_window", "n_ctx")
"""Fields that state the context in lists of models: vLLM, OpenRouter, Groq, llama.cpp (under `meta`)."""

READY = Tool(
    "ready",
    "Say that you are ready.",
    {
        "type": "object",
        "properties": {"ready": {"type": "boolean"}},
        "required": ["ready"],
        "additionalProperties": False,
    },
)
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


def preflight_model(model: ChatModel, limit_s: float = LIMIT_S) -> tuple[str, ...]:
    """Send a model one short query and return the notes about missing features, one line each.

    Raises:
        PermanentReasonerError: Queries would fail.
    """
    model = getattr(model, "inner", model)
    if not isinstance(model, _Described):
        return ()
    ends_at = time.monotonic() + limit_s
    _ask(model, ends_at)
    publish()
    notes = [f"{model.name} {note}" for note in model.takes.notes]
    described = model.described(max(ends_at - time.monotonic(), 1.0))
    _check_context(model.name, model.takes, context_of(described))
    if described.get("owned_by") == "library":
        notes.append(
            f"{model.name}: Ollama has 4,096 tokens of context unless OLLAMA_CONTEXT_LENGTH sets another value"
        )
    return tuple(notes)


def _ask(model: ChatModel, ends_at: float) -> None:
    picture = CameraImage(width=64, height=64, jpeg=GRAY_JPEG)
    turns = [Message("system", "You are asked whether you can be reached."), Message("user", "Ready?", image=picture)]
    while (pause_s := _asked(model, turns, ends_at)) is not None:
        time.sleep(pause_s)


def _asked(model: ChatModel, turns: list[Message], ends_at: float) -> float | None:
    """Return None after any answer, otherwise the time to wait for a busy server (s).

    Raises:
        PermanentReasonerError: Queries would fail.
    """
    try:
        model.chat(turns, [READY], READY.name, ends_at - time.monotonic())
    except TransientReasonerError as error:
        wait_s = max(error.after_s or 0.0, BUSY_PAUSE_S)
        if error.trouble is not TransientKind.BUSY or time.monotonic() + wait_s > ends_at:
            raise PermanentReasonerError(str(error)) from error
        return wait_s
    return None


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
