"""Translates the SDK's errors and the failures that servers report into typed errors, with the remedy."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from stucksolver.privacy.url_redaction import KEYS_VARIABLE
from stucksolver_language.llm.api_keys import KEY_VARIABLE
from stucksolver_language.llm.chat import PermanentReasonerError, TransientKind, TransientReasonerError
from stucksolver_language.llm.server_failure import ServerFailure, failure_of, one_line

ChatError = TransientReasonerError | PermanentReasonerError
LARGER_CONTEXT = "llama.cpp: --ctx-size, vLLM: --max-model-len, Ollama: OLLAMA_CONTEXT_LENGTH"
REFUSALS = (400, 415, 422, 500, 501)
"""Statuses with which servers reject an unknown part of a request."""
PASSING = (408, 409, 425, 502, 503, 504, 529)
"""Statuses of temporary failures; 529 is Anthropic's status for overloaded."""


def failure_from(error: Any) -> ServerFailure:
    """Return what an SDK error says about the server's failure."""
    response = getattr(error, "response", None)
    found = failure_of(
        getattr(error, "body", None),
        getattr(error, "status_code", None),
        str(error),
        getattr(response, "headers", None),
    )
    named = getattr(error, "param", None)
    return replace(found, parameter=named) if isinstance(named, str) and found.parameter is None else found


def translated(error: Any, where: str, model: str, *, keyed: bool, clean: Callable[[str], str]) -> ChatError:
    """Return the typed error for an SDK error.

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
    if isinstance(error, openai.APIStatusError):
        status = error.status_code
        if 300 <= status < 400:
            target = clean(str(error.response.headers.get("location", "")))[:200]
            return PermanentReasonerError(
                f"{where} redirects requests to {target or 'another address'}, which is not followed: name that address"
            )
        return error_for(failure_from(error), where, model, keyed=keyed, clean=clean)
    return TransientReasonerError(
        f"the response of {where} is not a chat completion: {clean(str(error))[:200]}", TransientKind.BROKEN
    )


def error_for(failure: ServerFailure, where: str, model: str, *, keyed: bool, clean: Callable[[str], str]) -> ChatError:
    """Return the typed error for a failure that a server reports, with the remedy and the server's own words.

    Args: as in `translated`.
    """
    status, message = failure.status, one_line(clean(failure.message))
    if failure.withheld:
        return PermanentReasonerError(f"{where}: {message}", paid=True)
    if status in (401, 403):
        return PermanentReasonerError(_no_entry(where, model, keyed), lasting=True)
    if status == 404:
        problem = f"{where} has no model {model!r}, or no chat completions at that address"
        return PermanentReasonerError(f"{problem} (its message: {message})", lasting=True)
    if status == 402 or failure.code == "insufficient_quota":
        return PermanentReasonerError(f"{where}: the account's quota is exhausted ({message})", lasting=True)
    if is_context_overflow(message):
        return PermanentReasonerError(
            f"{where}: the query and its answer do not fit its context ({message}); {LARGER_CONTEXT}"
        )
    if status == 429:
        text = f"{where} limits the rate of requests ({message})"
        return TransientReasonerError(text, TransientKind.BUSY, failure.after_s)
    answered = f"{where} answered {status or 'with an error'}: {message}"
    if status in PASSING:
        return TransientReasonerError(answered, TransientKind.BUSY, failure.after_s)
    if status is None or (status >= 500 and status != 501):
        return TransientReasonerError(answered, TransientKind.BROKEN, failure.after_s)
    return PermanentReasonerError(answered)


def _no_entry(where: str, model: str, keyed: bool) -> str:
    if keyed:
        return f"{where} rejects the key: set {KEY_VARIABLE}, or the server's own in {KEYS_VARIABLE}, for {model}"
    return (
        f"{where} requires a key, and none was sent: --send-key sends {KEY_VARIABLE} there, {KEYS_VARIABLE}='HOST=KEY' "
        "another one"
    )


def is_context_overflow(message: str) -> bool:
    """True if a server's message says that the prompt exceeds its context."""
    text = message.lower()
    return re.search(r"context[ _](?:length|size|window)|prompt is too long", text) is not None


def _no_connection(error: Any, where: str) -> ChatError:
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
