"""Guidance scripts: what is said when, in which wording."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import pytest

from stucksolver.solver import Question
from stucksolver_eval.guidance import GuidanceError, ScriptLine, ScriptPlayer, read_script


def line(**when: float) -> ScriptLine:
    return ScriptLine.model_validate({"when": when, "say": ["please overtake", "go around it"]})


def spoken(one: ScriptLine, *moments: tuple[float, float, float]) -> list[float]:
    """The times at which something is said."""
    speaker = ScriptPlayer([one], Random(1))
    return [time_s for time_s, place_m, speed in moments if speaker.due(time_s, place_m, speed)]


def test_a_line_is_said_once_at_its_time() -> None:
    assert spoken(line(time_s=8), (7.95, 0, 5), (8.0, 0, 5), (8.05, 0, 5)) == [8.0]


def test_or_at_its_place() -> None:
    assert spoken(line(place_m=50), (1, 49, 5), (2, 51, 5), (3, 52, 5)) == [2]


def test_or_after_so_long_at_a_stand() -> None:
    moments = ((0, 0, 0), (4, 0, 0), (4.5, 1, 3), (5, 2, 0), (9.4, 2, 0), (9.6, 2, 0))
    assert spoken(line(stopped_s=5), *moments) == [9.6]


def test_the_seed_chooses_the_wording() -> None:
    said = {ScriptPlayer([line(time_s=0)], Random(seed)).due(0, 0, 0)[0][1] for seed in range(20)}
    assert said == {"please overtake", "go around it"}
    assert ScriptPlayer([line(time_s=0)], Random(3)).due(0, 0, 0) == ScriptPlayer([line(time_s=0)], Random(3)).due(
        0, 0, 0
    )


def script(folder: Path, data: object) -> Path:
    path = folder / "script.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def test_a_script_is_read_by_route(tmp_path: Path) -> None:
    path = script(tmp_path, {"version": 1, "routes": {"7": [line(time_s=1).model_dump(mode="json")]}})
    found = read_script(path, {"7", "8"})
    assert (len(found.lines("7")), found.lines("8")) == (1, ())


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({"version": 2, "routes": {}}, "version"),
        ({"routes": {"7": [{"when": {}, "say": ["x"]}]}}, "exactly one of"),
        ({"routes": {"7": [{"when": {"time_s": 1}, "say": []}]}}, "either say"),
        ({"routes": {"7": [{"when": {"time_s": 1}}]}}, "either say"),
        ({"routes": {"7": [{"when": {"time_s": 1}, "answer": "yes"}]}}, "name the person"),
        ({"routes": {"9": []}}, "no route of the suite in file"),
    ],
)
def test_a_bad_script_is_named(tmp_path: Path, data: object, told: str) -> None:
    with pytest.raises(GuidanceError, match=told) as error:
        read_script(script(tmp_path, data), {"7"})
    assert "script.json" in str(error.value)


def question(number: int, to: str = "operator") -> Question:
    return Question(id=f"q{number}", time_s=0.0, kind="approval", to=to, text="May I?")


def answers(to: str = "operator", after_s: float = 4.0) -> ScriptLine:
    return ScriptLine.model_validate({"when": {"asked": to, "after_s": after_s}, "answer": "yes", "by": to})


def test_script_question_is_answered_late_by_addressee() -> None:
    """The person whom a question addresses answers it, after the delay of the script."""
    speaker = ScriptPlayer([answers()], Random(1))
    moments = [(10.0, question(1, "passenger")), (20.0, question(2)), (23.9, question(2)), (24.0, question(2))]
    assert [t for t, asked in moments if speaker.due(t, 0.0, 0.0, asked)] == [24.0]


def test_a_new_question_is_thought_about_anew() -> None:
    speaker = ScriptPlayer([answers()], Random(1))
    moments = [(1.0, question(1)), (4.0, question(2)), (6.0, None), (6.5, question(3)), (9.0, question(3))]
    assert not [t for t, asked in moments if speaker.due(t, 0.0, 0.0, asked)]
    assert speaker.due(10.6, 0.0, 0.0, question(3))[0][1] == "yes"
