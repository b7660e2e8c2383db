"""The cyclists' case with sentences that others wrote, each driven to its end."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from stucksolver.commands.main import main
from stucksolver_eval.cases import run_cases
from stucksolver_eval.cases.wordings import Wording, draw_wordings, outcome, passed_s, read_as, worded

pytest.importorskip(
    "onnxruntime", reason="the reader of words is not installed: add the extra [language] (README, Install)"
)
SENTENCES = Path(__file__).parents[4] / "results" / "words" / "cyclists.jsonl"
CHOSEN = ("b1-036", "b1-199", "b1-311")
"""One who asks to pass, one who asks not to, and one who only talks."""
DRIVE_S = 32.0
"""Whoever is asked to pass has passed by then."""


@pytest.fixture(scope="module")
def wordings():
    lines = [json.loads(line) for line in SENTENCES.read_text(encoding="utf-8").splitlines()]
    return [Wording(line["text"], line["intent"]) for line in lines if line["id"] in CHOSEN]


@pytest.fixture(scope="module")
def results(wordings, tmp_path_factory):
    cases = tuple(replace(case, drive_s=DRIVE_S) for case in worded(wordings))
    return run_cases(cases, "search", tmp_path_factory.mktemp("wordings"), pictures=False)


@pytest.mark.release
@pytest.mark.integration
def test_who_asks_to_pass_is_driven_past_and_nobody_else(results):
    assert [passed_s(result) is not None for result in results] == [True, False, False]
    assert [result.collisions for result in results] == [0, 0, 0]
    assert outcome(results[1]).startswith("stays behind")


@pytest.mark.release
@pytest.mark.integration
def test_each_was_read_as_its_author_meant_it(results, wordings):
    assert [read_as(result).intent.value for result in results] == [wording.meant for wording in wordings]


@pytest.mark.release
@pytest.mark.integration
def test_the_figure_has_a_row_for_each(results, wordings, tmp_path):
    from PIL import Image

    draw_wordings(wordings, results, tmp_path / "wordings.png")
    with Image.open(tmp_path / "wordings.png") as figure:
        assert figure.height > 58 * len(results)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("not json\n", ":1: invalid JSON"),
        ('{"words": "go"}\n', ':1: expected {"text"'),
        ("\n", "no sentence"),
        ("[]", "list"),
    ],
)
def test_a_file_of_other_things_is_named_with_its_line(tmp_path, capsys, content, told):
    file = tmp_path / "said.jsonl"
    file.write_text(content, encoding="utf-8")
    assert main(["cases", "--wordings", str(file), "--out", str(tmp_path / "out")]) == 2
    assert told in capsys.readouterr().err
