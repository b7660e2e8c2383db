"""Translates the SDK's errors into typed errors, with the remedy."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from stucksolver.privacy.url_redaction import KEYS_VARIABLE
from stucksolver_language.llm.api_keys import KEY_VARIABLE
from stucksolver_language.llm.chat import PermanentReasonerError, TransientKind, TransientReasonerError

LARGER_CONTEXT = "llama.cpp: --ctx-size, vLLM: --max-model-len, Ollama: OLLAMA_CONTEXT_LENGTH"
REFUSALS = (400, 415, 422, 500, 501)
"""Statuses with which servers reject an unknown part of a request."""
PASSING = (408, 409, 425, 502, 503, 504, 529)
"""Statuses of temporary failures; 529 is Anthropic's status for overloaded."""


def translated(error: Any, where: str, model: str, *, keyed: bool, clean: Callable[[str], str]) -> Exception:
    """Return a `TransientReasonerError` or `PermanentReasonerError` for an SDK error.

    Args:
        error: The error.
        where: Name of the server for people.
        model: Name of the model.
        keyed: A key was sent.
        clean: Makes the server's text safe to display.
    """
    import openai

    if isinstance(error, openai.APITimeoutError):
        return TransientReasonerError(f"{where} gave no answer in time", TransientKind.LATE)
    if isinstance(error, openai.APIConnectionError):
        return _no_connection(error, where)
    if isinstance(error, openai.AuthenticationError | openai.PermissionDeniedError):
        return PermanentReasonerError(_no_entry(where, model, keyed), lasting=True)
    if isinstance(error, openai.NotFoundError):
        problem = f"{where} has no model {model!r}, or no chat completions at that address"
        return PermanentReasonerError(f"{problem} (its message: {server_message(error, clean)})", lasting=True)
    if isinstance(error, openai.RateLimitError):
        return _rate_limit(error, where)
    if isinstance(error, openai.APIStatusError):
        return _by_status(error, where, clean)
    return TransientReasonerError(
        f"the response of {where} is not a chat completion: {clean(str(error))[:200]}", TransientKind.BROKEN
    )


def _no_entry(where: str, model: str, keyed: bool) -> str:
    if keyed:
        return f"{where} rejects the key: set {KEY_VARIABLE}, or the server's own in {KEYS_VARIABLE}, for {model}"
    return (
        f"{where} requires a key, and none was sent: --send-key sends {KEY_VARIABLE} there, {KEYS_VARIABLE}='HOST=KEY' "
        "another one"
    )


def _by_status(error: Any, where: str, clean: Callable[[str], str]) -> Exception:
    status, message = error.status_code, server_message(error, clean)
    if 300 <= status < 400:
        target = clean(str(error.response.headers.get("location", "")))[:200]
        return PermanentReasonerError(
            f"{where} redirects requests to {target or 'another address'}, which is not followed: name that address"
        )
    if is_context_overflow(message):
        return PermanentReasonerError(
            f"{where}: the query and its answer do not fit its context ({message}); {LARGER_CONTEXT}"
        )
    if status in PASSING:
        return TransientReasonerError(f"{where} answered {status}: {message}", TransientKind.BUSY, _after(error))
    if status >= 500 and status != 501:
        return TransientReasonerError(f"{where} answered {status}: {message}", TransientKind.BROKEN, _after(error))
    return PermanentReasonerError(f"{where} answered {status}: {message}")


def is_context_overflow(message: str) -> bool:
    """True if a server's message says that the prompt exceeds its context."""
    text = message.lower()
    return re.search(r"context[ _](?:length|size|window)|prompt is too long", text) is not None


def _no_connection(error: Any, where: str) -> Exception:
    cause: BaseException | None = error
    while cause is not None:
        if "CERTIFICATE" in str(cause).upper():
            text = f"{where} has a certificate that is not trusted: set SSL_CERT_FILE to the certificate of its issuer"
            return PermanentReasonerError(text, lasting=True)
        cause = cause.__cause__ or cause.__context__
    return TransientReasonerError(
        f"{where} cannot be reached or closed the connection: check that it is running and that its address is right",
        TransientKind.AWAY,
    )


def _rate_limit(error: Any, where: str) -> Exception:
    if getattr(error, "code", None) == "insufficient_quota":
        return PermanentReasonerError(f"{where}: the account's quota is exhausted", lasting=True)
    return TransientReasonerError(f"{where} limits the rate of requests", TransientKind.BUSY, _after(error))


def _after(error: Any) -> float | None:
    try:
        return max(float(error.response.headers["retry-after"]), 0.0)
    except (KeyError, ValueError, AttributeError):
        # Without a valid header, the caller uses its own pause.
        return None


def server_message(error: Any, clean: Callable[[str], str]) -> str:
    """Return the server's own message, cleaned and shortened, from OpenAI's error format or those of other servers."""
    body = getattr(error, "body", None)
    text: Any = None
    if isinstance(body, dict):
        inner = body.get("error")
        text = body.get("message") or body.get("detail") or (inner.get("message") if isinstance(inner, dict) else inner)
    return " ".join(clean(str(text or error)).split())[:300]


def parameter_of(error: Any) -> str | None:
    """Return the field of the request that an error names, if any."""
    named = getattr(error, "param", None)
    return named if isinstance(named, str) else None
