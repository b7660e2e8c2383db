"""Servers as they are: what each takes, ignores, refuses and leaves out, as llama.cpp, Ollama, vLLM and OpenAI do."""

from __future__ import annotations

import json
from contextlib import suppress
from importlib.util import find_spec

import mind
import pytest
from chat_server import Fault, available_in, picture_of

from stucksolver.query_budget import QueryBudget
from stucksolver.reasoners import ReasonerError, ReasonerRequest
from stucksolver.reasoners.factory import make_reasoner, preflight, sees
from stucksolver.reasoners.registry import ReasonerNameError
from stucksolver.scene import CameraImage, Guidance, LineKind
from stucksolver_language.llm import (
    LanguageModelReasoner,
    ModelSettings,
    PermanentReasonerError,
    Price,
    UsageLimits,
)
from stucksolver_language.llm.capabilities import capabilities_of
from stucksolver_language.llm.dialects import Dialect
from stucksolver_language.llm.model_options import ModelOptions
from stucksolver_language.llm.openai_api import OpenAiChat
from stucksolver_language.llm.prompt import FORM_SHORT, messages
from stucksolver_language.llm.tool_schema import MOST_PARTICIPANTS, decide_tool
from worlds import World, straight_road, thing

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)

MODEL = "reader"
IMAGE = CameraImage(width=8, height=8, jpeg=b"/9j/AAAA")


def scene(**update):
    made = World(straight_road(left=LineKind.BROKEN, oncoming=None), [thing("car", 60.0)]).scene()
    ego = made.ego.model_copy(update={"stopped_for_s": 20.0})
    return made.model_copy(update={"ego": ego, **update})


def good(sc):
    return mind.answer(messages(sc)[1].text, available_in(messages(sc)[1].text))


def asking(server, options="", model=MODEL, deadline_s=20.0, usage_limits=None):
    """As `openai:MODEL@URL#OPTIONS` makes it."""
    made = make_reasoner(f"openai:{model}@{server.url}{options}")
    return LanguageModelReasoner(made.model, settings=ModelSettings(deadline_s=deadline_s), usage_limits=usage_limits)


def as_openai(server, model=MODEL, deadline_s=20.0):
    """As OpenAI's own server is asked."""
    chat = OpenAiChat(model, server.url)
    chat.takes = capabilities_of(model, None, ModelOptions())
    return LanguageModelReasoner(chat, settings=ModelSettings(deadline_s=deadline_s))


# ---- the call


@pytest.mark.integration
def test_a_server_of_ones_own_is_asked_by_schema_first(server):
    assert asking(server).decide(ReasonerRequest(scene())).decision.plan is not None
    request = server.requests[0]
    assert request["response_format"]["json_schema"]["strict"] is True
    assert "tools" not in request and request["messages"][0]["content"].endswith(FORM_SHORT)


@pytest.mark.parametrize(
    ("ignores", "dialect"),
    [({"schema"}, Dialect.TOOL), ({"schema", "tools"}, Dialect.PROSE)],
)
def test_server_prose_answer_steps_down_dialect_within_query(server, ignores, dialect):
    """Prose in place of a call changes the dialect within the same query, and later queries keep that dialect."""
    server.ignores = ignores
    reasoner = asking(server)
    assert reasoner.decide(ReasonerRequest(scene())).decision.plan is not None
    assert reasoner.model.takes.dialect is dialect
    asked = len(server.requests)
    reasoner.decide(ReasonerRequest(scene()))
    assert len(server.requests) == asked + 1


def test_an_answer_in_prose_is_paid_for(server):
    server.ignores = {"schema"}
    reasoner = asking(server)
    trace = reasoner.decide(ReasonerRequest(scene())).trace
    assert reasoner.usage_limits.spent["trip"].tokens > 400 + trace.input_tokens / 2
    assert trace.output_tokens == 400


@pytest.mark.parametrize(
    "written",
    [
        lambda text: f'{{"name": "decide", "arguments": {text}}}',
        lambda text: f'{{"name": "decide", "parameters": {text}}}',
        lambda text: json.dumps({"name": "decide", "arguments": text}),
        lambda text: f'{{"type": "function", "function": {{"name": "decide", "arguments": {text}}}}}',
        lambda text: f'<tool_call>\n{{"name": "decide", "arguments": {text}}}\n</tool_call>',
        lambda text: f'{{"decide": {text}}}',
        lambda text: f'<think>Maybe {{"decision": 1}}? No: {{"decision": 2}}.</think>\n{text}',
    ],
)
def test_a_call_that_is_written_out_is_read(server, written):
    sc = scene()
    server.faults.append(Fault(message={"role": "assistant", "content": written(json.dumps(good(sc)))}))
    assert asking(server).decide(ReasonerRequest(sc)).decision.plan is not None
    assert len(server.requests) == 1


def test_server_check_plan_written_as_text_is_executed(server):
    """A call of check_plan that the model writes as text is treated as a call."""
    plan = {"behaviors": [{"name": "creep", "distance_m": 2, "speed_mps": 1}]}
    text = json.dumps({"name": "check_plan", "arguments": plan})
    server.faults.append(Fault(message={"role": "assistant", "content": text}))
    reasoner, asked = asking(server, "#call=tool"), []
    reasoner.decide(ReasonerRequest(scene(), check=lambda p: asked.append(p) or "accepted"))
    assert [b.name for b in asked[0].behaviors] == ["creep"]


# ---- pictures


def test_server_without_image_support_gets_images_once(server):
    """A model without image support is detected with the first image; later queries omit it, with one note."""
    server.lacks = {"pictures"}
    reasoner = asking(server)
    answers = [reasoner.decide(ReasonerRequest(scene(image=IMAGE))) for _ in range(3)]
    assert all(answer.decision.plan is not None for answer in answers)
    assert [picture_of(request) for request in server.requests] == [True, False, False, False]
    assert "omits pictures" in reasoner.model.takes.notes[0] and "mmproj" in reasoner.model.takes.notes[0]
    assert "image_sha256" not in answers[-1].trace.prompt


@pytest.mark.parametrize(
    "said",
    [
        "messages[1].content: Input should be a valid string",
        "unknown variant `image_url`, expected `text`",
        "At most 0 image(s) may be provided in one prompt.",
        "Invalid content type. image_url is only supported by certain models.",
        "this model does not support multimodal requests",
    ],
)
def test_every_servers_way_to_refuse_pictures_is_understood(server, said):
    server.faults.append(Fault(status=400, error={"message": said}))
    assert asking(server).decide(ReasonerRequest(scene(image=IMAGE))).decision.plan is not None
    assert [picture_of(request) for request in server.requests] == [True, False]


def test_pictures_can_be_switched_off(server):
    asking(server, "#pictures=off").decide(ReasonerRequest(scene(image=IMAGE)))
    assert not picture_of(server.requests[0])
    assert sees("openai:m") and not sees("openai:m#pictures=off") and not sees("search")


# ---- errors


def test_server_internal_error_is_quoted_and_retried_once(server):
    """An internal error of the server is quoted in the failure, after one retry only."""
    server.faults.extend([Fault(status=500, error={"message": "failed to parse grammar at line 3"})] * 20)
    reasoner = asking(server, "#call=prose")
    with pytest.raises(ReasonerError, match=r"500: failed to parse grammar at line 3.*twice"):
        reasoner.decide(ReasonerRequest(scene()))
    assert len(server.requests) == 2


def test_server_permanent_error_is_not_retried_at_once(server, monkeypatch):
    """An error that a person must fix is not sent again: three queries make one request."""
    monkeypatch.setenv("OPENAI_API_KEY", "wrong")
    server.key = "right"
    reasoner = asking(server)
    for _ in range(3):
        with pytest.raises(PermanentReasonerError, match="OPENAI_API_KEY"):
            reasoner.decide(ReasonerRequest(scene()))
    assert len(server.requests) == 1


@pytest.mark.parametrize(
    "said",
    [
        "This model's maximum context length is 4096 tokens. However, you requested 5500 tokens",
        "the request exceeds the available context size (4096 tokens), try increasing it",
    ],
)
def test_server_prompt_too_long_names_the_remedy(server, said):
    """When the prompt exceeds the context, the error gives the size of the context and how to enlarge it."""
    server.faults.append(Fault(status=400, error={"message": said}))
    with pytest.raises(PermanentReasonerError, match=r"4096.*OLLAMA_CONTEXT_LENGTH"):
        asking(server).decide(ReasonerRequest(scene()))
    assert len(server.requests) == 1


# ---- parameters


def test_a_reasoning_model_gets_no_temperature_and_room_to_think(server):
    server.lacks = {"temperature", "max_tokens", "parallel_tool_calls"}
    assert as_openai(server, "gpt-5-mini").decide(ReasonerRequest(scene())).decision.plan is not None
    request = server.requests[0]
    assert len(server.requests) == 1
    assert request["reasoning_effort"] == "low" and request["max_completion_tokens"] == 8000


@pytest.mark.parametrize("lacks", [{"temperature"}, {"max_tokens"}, {"temperature", "max_tokens"}])
def test_server_rejected_parameter_is_omitted_from_then_on(server, lacks):
    """A parameter that the server rejects is omitted from all later requests."""
    server.lacks = lacks
    reasoner = asking(server, model="deployment-7")
    assert reasoner.decide(ReasonerRequest(scene())).decision.plan is not None
    asked = len(server.requests)
    assert asked == 1 + len(lacks)
    reasoner.decide(ReasonerRequest(scene()))
    assert len(server.requests) == asked + 1
    assert not lacks & server.requests[-1].keys()


@pytest.mark.parametrize(("model", "thinks"), [("o3", True), ("gpt-5.1", True), ("gpt-5-chat-latest", False)])
def test_reasoning_models_are_known_by_name(model, thinks):
    assert (capabilities_of(model, None, ModelOptions()).effort == "low") is thinks


@pytest.mark.parametrize(("model", "thinks"), [("gpt-4o-2024-08-06", False), ("qwen2.5", False), ("o4-mini", True)])
def test_other_models_are_not(model, thinks):
    assert capabilities_of(model, None, ModelOptions()).temperature is not thinks


def test_a_server_that_refuses_everything_is_not_asked_for_ever(server):
    server.lacks = {"temperature", "max_tokens", "max_completion_tokens", "tools", "schema"}
    with pytest.raises(PermanentReasonerError, match="max_completion_tokens"):
        asking(server).decide(ReasonerRequest(scene(image=IMAGE)))
    assert len(server.requests) < 8


def test_server_azure_deployment_address_uses_api_key_header(server, monkeypatch):
    """An Azure deployment address gets the key in its api-key header, not as authorization."""
    monkeypatch.setenv("STUCKSOLVER_KEYS", "127.0.0.1=azure-key")
    server.key = "azure-key"
    base = server.url.replace("/v1", "/openai/deployments/my-gpt?api-version=2024-10-21")
    reasoner = make_reasoner(f"openai:my-gpt@{base}")
    assert reasoner.decide(ReasonerRequest(scene(), deadline_s=20.0)).decision.plan is not None
    assert server.paths == ["/openai/deployments/my-gpt/chat/completions?api-version=2024-10-21"]
    assert "authorization" not in server.headers[0]
    assert server.requests[0]["tools"][0]["function"]["strict"] is True


# ---- the answer's length


def test_an_answer_that_was_cut_off_is_said_to_be(server):
    text = json.dumps(good(scene()))
    server.faults.append(Fault(message={"role": "assistant", "content": text[:200]}, finish="length"))
    assert asking(server).decide(ReasonerRequest(scene())).decision.plan is not None
    assert "cut off at 200 tokens" in server.requests[1]["messages"][-1]["content"]


def test_a_model_that_only_thought_is_told_of(server):
    server.faults.extend([Fault(message={"role": "assistant", "content": ""}, finish="length")] * 2)
    with pytest.raises(ReasonerError, match=r"while the model was thinking; allow more with #tokens=N"):
        asking(server, "#tokens=1900").decide(ReasonerRequest(scene()))
    assert server.requests[0]["response_format"] and server.requests[1]["response_format"]


def test_an_answer_that_a_filter_withheld_is_a_failure(server):
    server.faults.append(Fault(message={"role": "assistant", "content": ""}, finish="content_filter"))
    with pytest.raises(PermanentReasonerError, match="content filter"):
        asking(server).decide(ReasonerRequest(scene()))


def test_more_tokens_may_be_allowed(server):
    asking(server, "#tokens=3000").decide(ReasonerRequest(scene()))
    assert server.requests[0]["max_tokens"] == 3000


# ---- bounds


def parts_of(schema):
    yield schema
    for value in schema.values() if isinstance(schema, dict) else schema:
        if isinstance(value, dict | list):
            yield from parts_of(value)


def test_every_list_and_every_text_has_an_end():
    for part in parts_of(decide_tool(scene()).parameters):
        if isinstance(part, dict) and part.get("type") == "array":
            assert part["maxItems"] <= 8
        if isinstance(part, dict) and part.get("type") == "string":
            assert "enum" in part or part["maxLength"] <= 240


def test_openais_strict_mode_gets_no_word_that_it_refuses(server):
    as_openai(server).decide(ReasonerRequest(scene()))
    assert "maxLength" not in json.dumps(server.requests[0])


def test_a_list_that_repeats_one_item_is_refused(server):
    data = good(scene())
    data["observation"]["participants"] *= MOST_PARTICIPANTS + 1
    server.faults.append(Fault(message={"role": "assistant", "content": json.dumps(data)}))
    asking(server).decide(ReasonerRequest(scene()))
    assert "participants" in server.requests[1]["messages"][-1]["content"]


def test_ranges_stand_in_the_words(server):
    asking(server).decide(ReasonerRequest(scene()))
    assert (
        "change_lane(side left|right, distance_m 15..150, speed_mps >0.5..11):"
        in server.requests[0]["messages"][0]["content"]
    )


# ---- what does not vary comes first


def test_words_of_the_system_are_the_same_in_every_scene(server):
    reasoner = asking(server)
    reasoner.decide(ReasonerRequest(scene()))
    reasoner.decide(ReasonerRequest(scene(guidance=Guidance(text="overtake", time_s=0.0))))
    other = World(straight_road(), [thing("bike", 70.0, speed=3.0), thing("van", 90.0)]).scene()
    reasoner.decide(ReasonerRequest(other))
    assert len({request["messages"][0]["content"] for request in server.requests}) == 1


def test_schema_is_the_same_in_every_request(server):
    reasoner = asking(server)
    for update in ({}, {"guidance": Guidance(text="overtake", time_s=0.0)}, {"objects": ()}):
        with suppress(ReasonerError):
            reasoner.decide(ReasonerRequest(scene(**update)))
    assert len({json.dumps(request["response_format"]) for request in server.requests}) == 1


# ---- the deadline and the budget


def test_the_deadline_that_is_told_is_kept(server):
    server.faults.append(Fault(wait_s=0.4))
    reasoner = asking(server, deadline_s=0.1)
    assert reasoner.decide(ReasonerRequest(scene(), deadline_s=20.0)).decision.plan is not None
    server.faults.append(Fault(wait_s=5.0))
    with pytest.raises(ReasonerError, match=r"deadline of 0\.2 s"):
        reasoner.decide(ReasonerRequest(scene(), deadline_s=0.2))


def test_a_question_whose_answer_came_too_late_is_paid_for(server):
    server.faults.extend([Fault(wait_s=3.0)] * 3)
    reasoner = asking(
        server, deadline_s=0.2, usage_limits=UsageLimits(Price(1.0, 1.0, 1.0), episode=QueryBudget(queries=2))
    )
    for _ in range(2):
        with pytest.raises(ReasonerError, match="deadline"):
            reasoner.decide(ReasonerRequest(scene()))
    spent = reasoner.usage_limits.spent["intervention"]
    assert spent.queries == 2 and spent.tokens > 4000 and spent.usd == pytest.approx(spent.tokens / 1e6)
    with pytest.raises(ReasonerError, match="budget of 2 queries"):
        reasoner.decide(ReasonerRequest(scene()))


def test_server_without_token_counts_is_charged_by_estimate(server):
    """If the server reports no token counts, the purse is charged with an estimate."""
    server.counts = False
    reasoner = asking(server)
    reasoner.decide(ReasonerRequest(scene()))
    assert reasoner.usage_limits.spent["trip"].tokens > 1000


# ---- before anything is driven


def test_a_preflight_is_one_request_that_learns_and_tells(server):
    server.lacks = {"pictures", "temperature"}
    reasoner = asking(server)
    notes = reasoner.preflight()
    assert len(notes) == 2 and all(note.startswith("openai:reader@") for note in notes)
    before = len(server.requests)
    reasoner.decide(ReasonerRequest(scene(image=IMAGE)))
    assert len(server.requests) == before + 1


def test_server_preflight_without_fault_makes_two_short_requests(server):
    """The second one proves that the picture of the first was counted. Both have the schema of a decision."""
    reasoner = asking(server)
    assert reasoner.preflight() == ()
    first, second = server.requests
    assert picture_of(first) and not picture_of(second)
    assert len(json.dumps(first["messages"])) < 1200 and first["max_tokens"] == 32
    reasoner.decide(ReasonerRequest(scene()))
    assert server.requests[2]["response_format"] == first["response_format"]


@pytest.mark.parametrize(
    ("entry", "context"),
    [
        ({"id": MODEL, "max_model_len": 2048}, 2048),
        ({"id": "some.gguf", "meta": {"n_ctx": 2048, "n_ctx_train": 8192}}, 2048),
    ],
)
def test_server_small_context_fails_preflight(server, entry, context):
    """A context that is too small for the prompt is an error before the drive."""
    server.models = [entry]
    with pytest.raises(PermanentReasonerError, match=rf"context too small: .* has {context} tokens.*--ctx-size"):
        asking(server).preflight()


def test_server_sufficient_context_gives_no_note(server):
    """A context that is large enough for the prompt gives no note."""
    server.models = [{"id": MODEL, "max_model_len": 5200}, {"id": "other", "max_model_len": 512}]
    assert asking(server).preflight() == ()


def test_ollamas_default_is_told(server):
    server.models = [{"id": MODEL, "object": "model", "owned_by": "library"}]
    assert "4,096" in asking(server).preflight()[0]


@pytest.mark.integration
def test_a_busy_server_is_waited_for(server):
    server.faults.append(Fault(status=503, headers={"retry-after": "0"}, error={"message": "Loading model"}))
    assert asking(server).preflight() == ()
    assert len(server.requests) == 3


@pytest.mark.parametrize(
    "words", ["openai:x@notaurl", "openai:x@ftp://h/v1", "openai:x@http://", "openai:x@http://a b"]
)
def test_what_is_no_address_is_refused_by_name(words):
    with pytest.raises(ReasonerNameError, match="not an address"):
        make_reasoner(words)


@pytest.mark.parametrize("option", ["pictures=maybe", "tokens=1", "tokens=x", "effort=huge", "call=shout", "foo=1", ""])
def test_options_that_do_not_exist_are_named(option):
    with pytest.raises(ReasonerNameError, match="unknown option: #"):
        make_reasoner(f"openai:m#{option}")


def test_an_unknown_model_is_found_before_the_drive(server):
    with pytest.raises(ReasonerNameError, match=r"openai:absent.*cannot be used.*no model 'absent'"):
        preflight(asking(server, model="absent"), "openai:absent")


def test_all_in_a_row_are_checked(server):
    both = make_reasoner(f"search, openai:absent@{server.url}")
    with pytest.raises(ReasonerError, match="absent"):
        both.preflight()
