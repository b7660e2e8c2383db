"""Failures that servers report inside responses of status 200, and requests that they refuse in part."""

from __future__ import annotations

import time
from importlib.util import find_spec

import pytest
from answer_forms import SCENE, bytes_of, chat, reasoner_at
from chat_server import Fault

from stucksolver.reasoners import ReasonerError, ReasonerRequest
from stucksolver_language.llm import LanguageModelReasoner, ModelSettings, TransientReasonerError
from stucksolver_language.llm.chat import TransientKind

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)


# ---- failures inside a response of status 200

NESTED = {
    "message": "Provider returned error",
    "code": 402,
    "metadata": {"raw": "Insufficient credits", "provider_name": "X"},
}
FAILURES = {
    "OpenRouter, proxy and provider": (
        {"error": NESTED, "choices": None},
        "Provider returned error: Insufficient credits",
    ),
    "error as a text": ({"error": "model runner has unexpectedly stopped"}, "runner has unexpectedly stopped"),
    "list of errors (Gemini)": (
        [{"error": {"code": 400, "message": "Invalid value at x", "status": "INVALID_ARGUMENT"}}],
        "Invalid value at x",
    ),
    "object error (vLLM)": (
        {"object": "error", "message": "prompt is empty", "type": "BadRequestError", "code": 400},
        "prompt is empty",
    ),
    "detail": ({"detail": "Not enough workers"}, "Not enough workers"),
    "detail list (FastAPI)": ({"detail": [{"loc": ["body"], "msg": "field required"}]}, "field required"),
    "Anthropic": ({"type": "error", "error": {"type": "overloaded_error", "message": "Overloaded"}}, "Overloaded"),
    "base_resp (MiniMax)": (
        {"choices": None, "base_resp": {"status_code": 1008, "status_msg": "insufficient balance"}},
        "insufficient balance",
    ),
    "errors (Cloudflare)": ({"success": False, "errors": [{"code": 7003, "message": "no route"}]}, "no route"),
    "code and message (DashScope)": (
        {"code": "DataInspectionFailed", "message": "Input may be inappropriate"},
        "may be inappropriate",
    ),
    "no choices": ({"id": "x", "choices": [], "warning": "quota note"}, "quota note"),
    "error in the choice": (
        chat("", "error", {"error": {"code": 502, "message": "upstream dropped"}}),
        "upstream dropped",
    ),
    "refusal": (chat(None, refusal="I can't help with driving."), "declines.*help with driving"),
    "refusal part": (chat([{"type": "refusal", "refusal": "Not this."}]), "declines.*Not this"),
    "filter with words": (
        chat("The response was filtered.", "content_filter"),
        "content filter.*response was filtered",
    ),
    "filter (Gemini)": ({"candidates": [{"finishReason": "SAFETY"}]}, "content filter.*safety"),
    "blocked prompt (Gemini)": (
        {"promptFeedback": {"blockReason": "PROHIBITED_CONTENT"}},
        "content filter.*prohibited_content",
    ),
    "no resources (DeepSeek)": (chat("", "insufficient_system_resource"), "insufficient_system_resource"),
    "page": (b"<html><body>503 upstream</body></html>", "begins.*503 upstream"),
    "empty body": (b"", "not a chat completion"),
    "error in a stream": (
        b'data: {"choices":[{"delta":{"content":"I"}}]}\n\ndata: {"error":{"code":502,"message":"lost a worker"}}\n\n',
        "lost a worker",
    ),
}


@pytest.mark.parametrize("form", FAILURES)
def test_failure_in_a_good_status_is_quoted(server, form):
    """The provider's own words are in the message, in one line of bounded length."""
    body, words = FAILURES[form]
    server.faults.extend([Fault(body=bytes_of(body))] * 20)
    with pytest.raises(ReasonerError, match=words) as caught:
        reasoner_at(server, deadline_s=3.0).decide(ReasonerRequest(SCENE))
    text = str(caught.value)
    assert "\n" not in text and len(text) < 700 and "no choice" not in text


class LateModel:
    """States that it is busy, and is late from then on."""

    name, asked = "late", 0

    def chat(self, messages, tools, must_call, limit_s):
        self.asked += 1
        if self.asked == 1:
            raise TransientReasonerError("all workers are busy", TransientKind.BUSY)
        time.sleep(limit_s)
        raise TransientReasonerError("gave no answer", TransientKind.LATE)

    def cancel(self):
        """Nothing runs."""


def test_words_of_the_server_outlast_a_late_attempt():
    """The last attempt is late. The message quotes what the server stated before."""
    reasoner = LanguageModelReasoner(LateModel(), settings=ModelSettings(deadline_s=0.5))
    with pytest.raises(ReasonerError, match=r"all workers are busy.*deadline of"):
        reasoner.decide(ReasonerRequest(SCENE))


@pytest.mark.parametrize("form", ["OpenRouter, proxy and provider", "refusal", "list of errors (Gemini)"])
def test_failure_that_cannot_pass_is_not_retried(server, form):
    server.faults.extend([Fault(body=bytes_of(FAILURES[form][0]))] * 20)
    with pytest.raises(ReasonerError):
        reasoner_at(server).decide(ReasonerRequest(SCENE))
    assert len(server.requests) == 1


@pytest.mark.parametrize(
    "error",
    [
        {"code": 429, "message": "Too Many Requests"},
        {"code": "rate_limit_exceeded", "message": "slow"},
        {"type": "overloaded_error", "message": "Overloaded"},
        {"message": "please try again later"},
        {"status": "UNAVAILABLE", "message": "no capacity"},
    ],
)
def test_failure_that_can_pass_is_retried(server, error):
    server.faults.append(Fault(body=bytes_of({"error": error})))
    assert reasoner_at(server).decide(ReasonerRequest(SCENE)).decision.plan is not None
    assert len(server.requests) == 2


def test_failure_is_quoted_without_keys_control_sequences_and_excess(server, monkeypatch):
    monkeypatch.setenv("STUCKSOLVER_KEYS", f"{server.url.removesuffix('/v1')}=sk-very-secret")
    message = "bad\x1b[2J key sk-very-secret\nline " + "x" * 9000
    server.faults.extend([Fault(body=bytes_of({"error": {"code": 400, "message": message}}))] * 3)
    with pytest.raises(ReasonerError) as caught:
        reasoner_at(server).decide(ReasonerRequest(SCENE))
    text = str(caught.value)
    assert "sk-very" not in text and "\x1b" not in text and "\n" not in text and len(text) < 500


@pytest.mark.parametrize("status", [200, 400])
def test_key_in_escapes_is_not_quoted(server, monkeypatch, status):
    """A body without words is quoted itself. A key in it may be written in JSON's escapes."""
    monkeypatch.setenv("STUCKSOLVER_KEYS", f"{server.url.removesuffix('/v1')}=sk-very-secret")
    escaped = "".join(f"\\u{ord(c):04x}" for c in "sk-very-secret")
    server.faults.extend([Fault(status=status, body=f'{{"seen": "{escaped}"}}'.encode())] * 3)
    with pytest.raises(ReasonerError) as caught:
        reasoner_at(server, deadline_s=1.0).decide(ReasonerRequest(SCENE))
    assert "sk-very" not in str(caught.value) and escaped not in str(caught.value)
