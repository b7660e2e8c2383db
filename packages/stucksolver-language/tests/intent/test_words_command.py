"""`stucksolver words`: lines in, readings out, one clear error for what cannot be read."""

from __future__ import annotations

import json

import pytest

from stucksolver.commands import main


def lines(tmp_path, *said):
    file = tmp_path / "in.jsonl"
    file.write_text("\n".join(s if isinstance(s, str) else json.dumps(s) for s in said), encoding="utf-8")
    return str(file)


def test_each_line_gets_one_reading(tmp_path, capsys):
    file = lines(
        tmp_path, {"situation": "Driving behind two cyclists.", "text": "overtake them"}, {"text": "wait!"}, ""
    )
    assert main(["words", file]) == 0
    first, second = map(json.loads, capsys.readouterr().out.splitlines())
    assert (first["intent"], second["intent"]) == ("overtake", "wait")
    assert first["reader"].startswith("words-")


@pytest.mark.parametrize(
    "broken", ["not json", "[]", '{"situation": "x"}', '{"text": 3}', '{"text": "x", "situation": {}}']
)
def test_a_line_that_cannot_be_read_is_named(tmp_path, capsys, broken):
    assert main(["words", lines(tmp_path, {"text": "go"}, broken)]) == 2
    assert "in.jsonl:2" in capsys.readouterr().err


def test_a_file_that_is_not_there_is_named(tmp_path, capsys):
    assert main(["words", str(tmp_path / "none.jsonl")]) == 2
    assert "none.jsonl" in capsys.readouterr().err
