"""The table of families: which row a name resolves to, and what a request to it holds."""

from __future__ import annotations

import re
from importlib.util import find_spec

import pytest
from answer_forms import SCENE, reasoner_at
from chat_server import Fault

from stucksolver.reasoners import ReasonerRequest
from stucksolver.reasoners.factory import make_reasoner, sees
from stucksolver.reasoners.registry import ReasonerNameError
from stucksolver_language.llm.capabilities import capabilities_of
from stucksolver_language.llm.chat import Message
from stucksolver_language.llm.model_families import family_of, model_families, server_kinds, server_of
from stucksolver_language.llm.model_options import ModelOptions, parse_options
from stucksolver_language.llm.openai_format import request_of
from stucksolver_language.llm.tool_schema import decide_tool

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)

OWN = "http://127.0.0.1:8000/v1"
OLLAMA = "http://127.0.0.1:11434/v1"
GEMINI = "https://generativelanguage.googleapis.com/v1beta/openai"
ANTHROPIC = "https://api.anthropic.com/v1"

NAMES = {
    "OpenAI o-series": ("o1", "o3-mini", "o4-mini-2025-04-16", "openai/o3"),
    "GPT-5 chat": ("gpt-5-chat-latest", "gpt-5.2-chat-latest"),
    "GPT-5.1 and later": ("gpt-5.1", "gpt-5.6-luna", "openai/gpt-5.4-mini", "gpt-6"),
    "GPT-5": ("gpt-5", "gpt-5-mini", "gpt-5-nano-2025-08-07"),
    "gpt-oss": ("gpt-oss:20b", "openai/gpt-oss-120b"),
    "Qwen3.5, 3.6, 3.7, 3.8": ("Qwen/Qwen3.5-9B", "qwen3.5:4b", "qwen3.6-plus", "unsloth/Qwen3.8-35B-A3B-GGUF"),
    "Qwen3 Instruct and Coder": ("Qwen/Qwen3-VL-8B-Instruct", "qwen3-coder:30b", "Qwen/Qwen3-30B-A3B-Instruct-2507"),
    "Qwen3 Thinking, QwQ": ("Qwen/Qwen3-VL-8B-Thinking", "Qwen/QwQ-32B", "qwen3-30b-a3b-thinking-2507"),
    "Qwen3": ("qwen3:8b", "Qwen/Qwen3-8B", "qwen3-vl:8b", "qwen3"),
    "Gemma 4": ("google/gemma-4-31B-it", "gemma4:12b"),
    "Cosmos-Reason": ("nvidia/Cosmos-Reason2-8B", "cosmos-reason1-7b"),
    "DeepSeek R1": ("deepseek-r1:8b", "deepseek-ai/DeepSeek-R1-0528", "deepseek-reasoner"),
    "DeepSeek V3.1, V3.2": ("deepseek-ai/DeepSeek-V3.2", "deepseek-v3.1"),
    "DeepSeek V4": ("deepseek-ai/DeepSeek-V4-Pro", "deepseek-v4-flash"),
    "GLM-5.3": ("zai-org/GLM-5.3",),
    "GLM-4.5 to 5.2": ("zai-org/GLM-4.7", "glm-5.1", "GLM-4.6V"),
    "Kimi K2 Thinking": ("moonshotai/Kimi-K2-Thinking",),
    "Kimi K2.5 and later": ("moonshotai/Kimi-K2.5", "kimi-k3"),
    "MiniMax M2": ("MiniMaxAI/MiniMax-M2",),
    "Nemotron 3": ("nvidia/nemotron-3-nano", "nvidia/NVIDIA-Nemotron-3-Nano-30B-A3B-BF16"),
    "Magistral": ("mistralai/Magistral-Small-2509",),
    "Mistral Small and Medium": ("mistral-small-latest", "mistral-medium-latest"),
    "Claude that always thinks": ("claude-opus-5-5", "claude-sonnet-5-5", "claude-fable-5"),
    "Claude 5": ("claude-sonnet-5", "claude-opus-5", "claude-haiku-5-5"),
    "Claude Opus 4.7, 4.8": ("claude-opus-4-7", "anthropic/claude-opus-4-8"),
    "Claude 4.6": ("claude-sonnet-4-6", "claude-opus-4-6"),
    "Claude 4.5 and before": ("claude-haiku-4-5", "claude-sonnet-4-5-20250929", "claude-3-5-sonnet-latest"),
    "Gemini 2.5 Pro": ("gemini-2.5-pro", "models/gemini-2.5-pro"),
    "Gemini 2.5 Flash": ("gemini-2.5-flash", "gemini-2.5-flash-lite"),
    "Gemini 3": ("gemini-3-pro-preview", "gemini-3.5-flash", "google/gemini-3.1-pro-preview"),
    "unknown": ("gpt-4o-2024-08-06", "qwen2.5-vl", "llama3.2", "smollm2", "gemma3:4b", "reader", "foo-o3"),
}


@pytest.mark.parametrize(("name", "family"), [(name, family) for family, names in NAMES.items() for name in names])
def test_family_is_found_by_the_name(name, family):
    assert family_of(name).name == family


def test_every_row_of_the_table_is_resolved_and_has_a_source():
    assert {family.name for family in model_families()} == NAMES.keys() - {"unknown"}
    for row in (*model_families(), *server_kinds()):
        assert row.source
    for family in model_families():
        assert re.compile(family.models).pattern == family.models.lower() or "\\d" in family.models
        assert family.thinks in ("never", "asked", "default", "always")


@pytest.mark.parametrize(
    ("url", "server"),
    [
        (None, "OpenAI and Azure"),
        ("https://eu.api.openai.com/v1", "OpenAI and Azure"),
        ("https://x.openai.azure.com/openai/v1", "OpenAI and Azure"),
        ("http://127.0.0.1:9/openai/deployments/x?api-version=1", "OpenAI and Azure"),
        (ANTHROPIC, "Anthropic"),
        (GEMINI, "Gemini"),
        ("https://api.mistral.ai/v1", "Mistral"),
        (OLLAMA, "Ollama"),
        (OWN, "vLLM, SGLang, llama.cpp and others"),
        ("https://notapi.openai.com.example.org/v1", "vLLM, SGLang, llama.cpp and others"),
    ],
)
def test_server_is_found_by_its_address(url, server):
    assert server_of(url).name == server


# ---- thinking


@pytest.mark.parametrize(
    ("model", "url", "think", "effort", "body"),
    [
        ("qwen3.5:9b", OWN, False, "none", {"chat_template_kwargs": {"enable_thinking": False}}),
        ("qwen3.5:9b", OWN, True, "medium", {"chat_template_kwargs": {"enable_thinking": True}}),
        ("qwen3.5:9b", OLLAMA, False, "none", {}),
        ("qwen3.5:9b", OWN, None, None, {}),
        ("kimi-k2.5", OWN, False, "none", {"chat_template_kwargs": {"thinking": False}}),
        ("gpt-5", None, False, "minimal", {}),
        ("gpt-5.2", None, False, "none", {}),
        ("gpt-5.2", None, None, "low", {}),
        ("o3", None, False, "low", {}),
        ("gpt-oss:20b", OLLAMA, False, "low", {}),
        ("gpt-oss:20b", OLLAMA, None, "low", {}),
        ("claude-opus-4-7", ANTHROPIC, True, None, {"thinking": {"type": "adaptive"}}),
        ("claude-opus-4-7", ANTHROPIC, False, None, {"thinking": {"type": "disabled"}}),
        ("claude-haiku-4-5", ANTHROPIC, True, None, {"thinking": {"type": "enabled", "budget_tokens": 4096}}),
        ("gemini-3-pro-preview", GEMINI, None, "low", {}),
        ("gemini-2.5-flash", GEMINI, False, "none", {}),
        ("a-model-of-mine", OWN, False, "none", {"chat_template_kwargs": {"enable_thinking": False}}),
        ("gpt-4o", None, None, None, {}),
    ],
)
def test_thinking_is_switched_in_the_spelling_of_the_server(model, url, think, effort, body):
    takes = capabilities_of(model, url, ModelOptions(think=think))
    assert (takes.effort, takes.body) == (effort, body)


@pytest.mark.parametrize(
    ("model", "think", "tokens"),
    [
        ("qwen3.5:9b", None, 8000),
        ("qwen3.5:9b", False, 1900),
        ("claude-sonnet-4-6", None, 1900),
        ("claude-sonnet-4-6", True, 8000),
        ("gpt-oss:20b", False, 8000),
        ("llama3.2", None, 1900),
    ],
)
def test_model_that_thinks_has_room_to(model, think, tokens):
    assert capabilities_of(model, OWN, ModelOptions(think=think)).most_tokens == tokens


@pytest.mark.parametrize(
    ("model", "options", "note"),
    [
        ("qwen3.5:9b", "", "#think=off answers sooner"),
        ("o3", "#think=off", "thinks all the same"),
        ("gpt-oss:20b", "", "omits pictures: gpt-oss reads text only"),
    ],
)
def test_note_says_what_the_family_does(model, options, note):
    takes = make_reasoner(f"openai:{model}@{OWN}{options}").model.takes
    assert any(note in text for text in takes.notes)


@pytest.mark.parametrize(("model", "omitted"), [("qwen3.5:9b", True), ("qwen2.5", False), ("gemini-3.5-flash", True)])
def test_temperature_is_omitted_where_it_does_harm(model, omitted):
    assert capabilities_of(model, OWN, ModelOptions()).temperature is not omitted


def test_no_picture_is_rendered_for_a_family_that_reads_text_only():
    assert not sees("openai:gpt-oss:20b@http://127.0.0.1:1/v1") and sees("openai:qwen3.5:9b")


# ---- schemas


@pytest.mark.parametrize(
    ("url", "refused"),
    [
        (GEMINI, {"maxLength", "exclusiveMinimum", "exclusiveMaximum"}),
        (ANTHROPIC, {"maxLength", "maxItems", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"}),
        (None, {"maxLength"}),
        (OWN, set()),
    ],
)
def test_keywords_that_a_server_refuses_are_not_sent(url, refused):
    takes = capabilities_of("some-model", url, ModelOptions())
    request = request_of("some-model", [Message("system", ""), Message("user", "")], [decide_tool(SCENE)], None, takes)
    text = str(request)
    assert not any(f"'{word}'" in text for word in refused)
    assert refused or "'maxLength'" in text


# ---- the body


def test_fields_of_the_body_are_sent(server):
    reasoner_at(server, "#body.top_k=20#body.chat_template_kwargs.custom=yes#think=off").decide(ReasonerRequest(SCENE))
    (request,) = server.requests
    assert request["top_k"] == 20
    assert request["chat_template_kwargs"] == {"custom": "yes", "enable_thinking": False}


def test_field_of_the_body_that_is_refused_is_omitted(server):
    server.faults.append(Fault(status=400, error={"message": "Unrecognized request argument supplied: top_k"}))
    reasoner = reasoner_at(server, "#body.top_k=20#body.min_p=0.1")
    assert reasoner.decide(ReasonerRequest(SCENE)).decision.plan is not None
    assert ["top_k" in request for request in server.requests] == [True, False]
    assert server.requests[1]["min_p"] == 0.1 and reasoner.model.takes.notes[0].startswith("omits top_k")


@pytest.mark.parametrize(
    "option",
    ["body.messages=1", "body.model=x", "body.tools=1", "body.=1", "body.a..b=1", "body.x.api_key=1", "think=maybe"],
)
def test_option_that_may_not_be_set_is_named(option):
    with pytest.raises(ReasonerNameError, match="unknown option"):
        make_reasoner(f"openai:m@{OWN}#{option}")


def test_body_options_merge_by_path():
    options = parse_options(["body.a.b=1", "body.a.c=[2]", "body.d=text"])
    assert options.body_fields() == {"a": {"b": 1, "c": [2]}, "d": "text"}
