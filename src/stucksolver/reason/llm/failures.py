"""Translates the SDK's errors into our own types, with the remedy."""

from __future__ import annotations

import re
from typing import Any

from stucksolver.reason.llm.chat import GiveUp, Trouble, TryAgain

KEY_VARIABLE = "OPENAI_API_KEY"
LARGER_CONTEXT = "llama.cpp: --ctx-size, vLLM: --max-model-len, Ollama: OLLAMA_CONTEXT_LENGTH"
REFUSALS = (400, 415, 422, 500, 501)
"""Statuses with which servers refuse a part of a request that they do not know."""
PASSING = (408, 409, 425, 502, 503, 504, 529)
"""Statuses of temporary failures; 529 is Anthropic's status for overloaded."""


def translated(error: Any, where: str, model: str) -> Exception:
    """Return a `TryAgain` or `GiveUp` for an SDK error."""
    import openai

    if isinstance(error, openai.APITimeoutError):
        return TryAgain(f"{where} gave no answer in time", Trouble.LATE)
    if isinstance(error, openai.APIConnectionError):
        return _no_connection(error, where)
    if isinstance(error, openai.AuthenticationError | openai.PermissionDeniedError):
        return GiveUp(f"{where} refuses the key: set {KEY_VARIABLE} to one that may use {model}", lasting=True)
    if isinstance(error, openai.NotFoundError):
        said = f"{where} has no model {model!r}, or no chat completions under that address"
        return GiveUp(f"{said} (it said: {said_by(error)})", lasting=True)
    if isinstance(error, openai.RateLimitError):
        return _rate_limit(error, where)
    if isinstance(error, openai.APIStatusError):
        return _by_status(error, where)
    return TryAgain(f"{where} did not answer with a chat completion: {str(error)[:200]}", Trouble.BROKEN)


def _by_status(error: Any, where: str) -> Exception:
    status, said = error.status_code, said_by(error)
    if too_long(said):
        return GiveUp(f"{where}: the question and its answer do not fit its context ({said}); {LARGER_CONTEXT}")
    if status in PASSING:
        return TryAgain(f"{where} answered {status}: {said}", Trouble.BUSY, _after(error))
    if status >= 500 and status != 501:
        return TryAgain(f"{where} answered {status}: {said}", Trouble.BROKEN, _after(error))
    return GiveUp(f"{where} answered {status}: {said}")


def too_long(said: str) -> bool:
    """True if a server says that the prompt exceeds its context."""
    text = said.lower()
    return re.search(r"context[ _](?:length|size|window)|prompt is too long", text) is not None


def _no_connection(error: Any, where: str) -> Exception:
    cause: BaseException | None = error
    while cause is not None:
        if "CERTIFICATE" in str(cause).upper():
            text = f"{where} has a certificate that is not trusted: set SSL_CERT_FILE to its issuer's"
            return GiveUp(text, lasting=True)
        cause = cause.__cause__ or cause.__context__
    return TryAgain(f"{where} cannot be reached or hung up: is it running, and is the address right?", Trouble.AWAY)


def _rate_limit(error: Any, where: str) -> Exception:
    if getattr(error, "code", None) == "insufficient_quota":
        return GiveUp(f"{where}: the account's quota is exhausted", lasting=True)
    return TryAgain(f"{where} limits the rate of requests", Trouble.BUSY, _after(error))


def _after(error: Any) -> float | None:
    try:
        return max(float(error.response.headers["retry-after"]), 0.0)
    except (KeyError, ValueError, AttributeError):
        return None


def said_by(error: Any) -> str:
    """Return the server's own words, shortened, from OpenAI's error format or those of other servers."""
    body = getattr(error, "body", None)
    text: Any = None
    if isinstance(body, dict):
        inner = body.get("error")
        text = body.get("message") or body.get("detail") or (inner.get("message") if isinstance(inner, dict) else inner)
    return " ".join(str(text or error).split())[:300]


def parameter_of(error: Any) -> str | None:
    """Return the field of the request that an error names, if any."""
    named = getattr(error, "param", None)
    return named if isinstance(named, str) else None
