"""`demo --say`: any sentence of a passenger's, driven in both streets."""

from __future__ import annotations

import gzip
import json

import pytest

from stucksolver.commands.main import main

pytest.importorskip("carla")
pytest.importorskip(
    "onnxruntime", reason="the reader of words is not installed: add the extra [language] (README, Install)"
)


def said(tmp_path, capsys, words):
    assert main(["demo", "--out", str(tmp_path), "--no-pictures", "--say", words]) == 0
    packed = sorted((tmp_path / "runs").glob("*/seed-1/replays/*.json.gz"))
    logs = [json.loads(gzip.decompress(path.read_bytes())) for path in packed]
    return capsys.readouterr().out, logs


@pytest.mark.release
@pytest.mark.integration
def test_demo_say_prints_interpretation_wait_reason_and_outcome(tmp_path, capsys):
    """In both streets, the output contains the interpretation, the reason for waiting and the outcome."""
    out, logs = said(tmp_path, capsys, "Be a dear and slip round that one in front")
    assert [log["result"]["plans_accepted"] for log in logs] == [1, 1]
    assert out.index("passenger: Be a dear") < out.index("car: understood: overtake (")
    assert out.count("passenger: Be a dear and slip round that one in front") == 2
    assert out.count("car: understood: overtake (") == 2
    # The guard may end the pass of the parked car on its way back, for its door; by then the ego has recovered.
    assert "in the oncoming lane" in out and ": done" in out and "recovered: 15 m of new progress" in out
    assert max(map(len, out.splitlines())) <= max(80, len(str(tmp_path)) + 30)


@pytest.mark.parametrize(("words", "why"), [("  ", "--say is empty"), ("x" * 501, "at most 500")])
def test_what_cannot_be_said_is_refused_before_anything_is_driven(tmp_path, capsys, words, why):
    assert main(["demo", "--out", str(tmp_path / "out"), "--say", words]) == 2
    assert why in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
