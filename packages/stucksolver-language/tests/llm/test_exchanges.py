"""Kept requests and answers: a run is made again without the network."""

from __future__ import annotations

import base64
import json
from importlib.util import find_spec

import mind
import pytest
from chat_server import Fault, available_in

from stucksolver.reasoners import ReasonerError, ReasonerRequest, SearchReasoner
from stucksolver.reasoners.factory import make_reasoner
from stucksolver.reasoners.fallback import FallbackReasoner
from stucksolver.reasoners.registry import ReasonerNameError
from stucksolver.scene import CameraImage, LineKind
from stucksolver_language.llm import LanguageModelReasoner, ModelSettings
from stucksolver_language.llm.exchanges import ExchangesError, RecordedChat, RecordingChat
from stucksolver_language.llm.openai_api import OpenAiChat
from stucksolver_language.llm.prompt import messages
from worlds import World, straight_road, thing

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)

IMAGE = CameraImage(width=8, height=8, jpeg=base64.b64encode(b"\xff\xd8" + bytes(500)))


def scene(x=60.0):
    made = World(straight_road(left=LineKind.BROKEN), [thing("car", x)]).scene()
    return made.model_copy(update={"image": IMAGE})


def good(scene_):
    return mind.answer(messages(scene_)[1].text, available_in(messages(scene_)[1].text))


def record(server, folder, *scenes):
    reasoner = LanguageModelReasoner(RecordingChat(OpenAiChat("reader", server.url), folder))
    return [reasoner.decide(ReasonerRequest(s)).decision for s in scenes]


@pytest.mark.integration
def test_the_same_questions_get_the_same_answers_without_the_network(server, tmp_path):
    made = record(server, tmp_path, scene(60.0), scene(62.0))
    count = len(server.requests)
    again = LanguageModelReasoner(RecordedChat(tmp_path))
    assert [
        again.decide(ReasonerRequest(scene(60.0))).decision,
        again.decide(ReasonerRequest(scene(62.0))).decision,
    ] == made
    assert len(server.requests) == count


def test_a_failure_that_passed_is_repeated_too(server, tmp_path):
    server.faults.append(Fault(status=503))
    record(server, tmp_path, scene())
    again = LanguageModelReasoner(RecordedChat(tmp_path))
    assert again.decide(ReasonerRequest(scene())).decision.plan is not None


def test_images_are_kept_once_by_their_digest(server, tmp_path):
    record(server, tmp_path, scene(60.0), scene(62.0))
    images = list((tmp_path / "images").iterdir())
    assert [p.read_bytes() for p in images] == [IMAGE.jpeg]
    lines = (tmp_path / "exchanges.jsonl").read_text(encoding="utf-8").splitlines()
    assert all(images[0].stem in line for line in lines)


def test_a_question_that_was_never_asked_is_a_failure(server, tmp_path):
    record(server, tmp_path, scene())
    with pytest.raises(ReasonerError, match="not among the recorded"):
        LanguageModelReasoner(RecordedChat(tmp_path)).decide(ReasonerRequest(scene(99.0)))


def test_a_changed_request_is_found(server, tmp_path):
    record(server, tmp_path, scene())
    path = tmp_path / "exchanges.jsonl"
    path.write_text(path.read_text(encoding="utf-8").replace("You never steer", "You steer", 1), encoding="utf-8")
    with pytest.raises(ExchangesError, match=r"line 1.*changed"):
        RecordedChat(tmp_path)


def test_a_folder_without_exchanges_is_named(tmp_path):
    with pytest.raises(ExchangesError, match=r"exchanges\.jsonl"):
        make_reasoner(f"recorded:{tmp_path}")


def test_a_disk_that_is_full_costs_the_record_only(server, tmp_path, monkeypatch):
    chat = RecordingChat(OpenAiChat("reader", server.url), tmp_path)
    (tmp_path / "exchanges.jsonl").mkdir()
    assert LanguageModelReasoner(chat).decide(ReasonerRequest(scene())).decision.plan is not None
    assert "no longer stored" in chat.fault


def test_raw_answer_is_kept_and_replayed(server, tmp_path):
    """The body as the server sent it stands in the record, also where its form is not that of chat completions."""
    scene_ = scene()
    parts = [{"type": "thinking", "thinking": "hm"}, {"type": "text", "text": json.dumps(good(scene_))}]
    server.faults.append(Fault(message={"role": "assistant", "content": parts}))
    (made,) = record(server, tmp_path, scene_)
    (line,) = (tmp_path / "exchanges.jsonl").read_text(encoding="utf-8").splitlines()
    reply = json.loads(line)["reply"]
    assert json.loads(reply["raw"])["choices"][0]["message"]["content"] == parts
    assert reply["thoughts"] == "hm" and "thinking" not in reply["text"]
    assert LanguageModelReasoner(RecordedChat(tmp_path)).decide(ReasonerRequest(scene_)).decision == made


def test_raw_answer_of_a_failure_is_kept_without_the_key(server, tmp_path, monkeypatch):
    monkeypatch.setenv("STUCKSOLVER_KEYS", f"{server.url.removesuffix('/v1')}=sk-very-secret")
    body = json.dumps({"error": {"code": 402, "message": "no credits", "metadata": {"seen": "sk-very-secret"}}})
    server.faults.append(Fault(body=body.encode()))
    with pytest.raises(ReasonerError, match="no credits"):
        record(server, tmp_path, scene())
    (line,) = (tmp_path / "exchanges.jsonl").read_text(encoding="utf-8").splitlines()
    assert json.loads(json.loads(line)["raw"])["error"]["code"] == 402 and "sk-very" not in line


def test_record_of_an_older_version_is_replayed(server, tmp_path):
    """Older records have neither the raw answer nor the thoughts."""
    (made,) = record(server, tmp_path, scene())
    path = tmp_path / "exchanges.jsonl"
    line = json.loads(path.read_text(encoding="utf-8"))
    for name in ("raw", "thoughts"):
        del line["reply"][name]
    path.write_text(json.dumps(line) + "\n", encoding="utf-8")
    assert LanguageModelReasoner(RecordedChat(tmp_path)).decide(ReasonerRequest(scene())).decision == made


# ---- the order of trust


def test_the_next_reasoner_answers_when_the_first_has_none(server):
    server.faults.extend([Fault(status=401, error={"message": "no"})] * 2)
    first = LanguageModelReasoner(OpenAiChat("reader", server.url), settings=ModelSettings(deadline_s=1.0))
    both = FallbackReasoner([first, SearchReasoner()])
    assert both.decide(ReasonerRequest(scene())).decision == SearchReasoner().decide(ReasonerRequest(scene())).decision
    assert "OPENAI_API_KEY" in both.failures[0]


def test_reasoners_have_names_on_the_command_line():
    both = make_reasoner("openai:gpt-4o-2024-08-06@http://127.0.0.1:9/v1, search")
    assert [r.name for r in both.reasoners] == [
        "openai:gpt-4o-2024-08-06@http://127.0.0.1:9/v1 (prompt 8)",
        SearchReasoner().name,
    ]


@pytest.mark.parametrize("words", ["", "gpt-4o", "openai:", "openai:@http://x", "rules,", "magic:1"])
def test_unknown_names_are_told_what_there_is(words):
    with pytest.raises(ReasonerNameError, match="openai:MODEL"):
        make_reasoner(words)


def test_nothing_of_a_key_is_kept(server, tmp_path, monkeypatch):
    monkeypatch.setenv("STUCKSOLVER_KEYS", f"{server.url.removesuffix('/v1')}=sk-very-secret")
    record(server, tmp_path, scene())
    assert server.headers[0]["authorization"] == "Bearer sk-very-secret"
    assert "sk-very" not in json.dumps((tmp_path / "exchanges.jsonl").read_text(encoding="utf-8"))


@pytest.mark.parametrize("existing", [False, True])
def test_exchanges_and_pictures_are_their_owners(server, tmp_path, existing):
    """Also in a folder that an older version wrote."""
    if existing:
        record(server, tmp_path, scene())
        for path in (tmp_path / "exchanges.jsonl", *(tmp_path / "images").iterdir()):
            path.chmod(0o644)
    record(server, tmp_path, scene())
    files = [tmp_path / "exchanges.jsonl", *(tmp_path / "images").iterdir()]
    assert [path.stat().st_mode & 0o777 for path in files] == [0o600, 0o600]
