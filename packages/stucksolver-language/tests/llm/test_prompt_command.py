"""`stucksolver prompt` shows what would be sent."""

from __future__ import annotations

import json

import pytest

from stucksolver.commands import main
from stucksolver_language.llm.prompt import ROLE
from worlds import World, straight_road, thing


@pytest.fixture
def scene():
    return World(straight_road(), [thing("car", 60.0)]).scene()


def test_a_scene_is_shown_with_its_function(scene, tmp_path, capsys):
    path = tmp_path / "scene.json"
    path.write_text(scene.model_dump_json(), encoding="utf-8")
    assert main(["prompt", str(path)]) == 0
    shown = capsys.readouterr().out
    assert ROLE in shown
    assert "car car ego 5.2" in shown
    assert '"borrow_oncoming_lane"' in shown


def test_the_first_scene_of_a_record_is_shown(scene, tmp_path, capsys):
    path = tmp_path / "record.jsonl"
    lines = [{"kind": "begin"}, {"event": {"scene": scene.model_dump(mode="json")}}]
    path.write_text("\n".join(json.dumps(line) for line in lines), encoding="utf-8")
    assert main(["prompt", "--json", str(path)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["messages"][0]["role"] == "system"
    assert told["tool"]["name"] == "decide"


@pytest.mark.parametrize("text", ["", "{}", '{"ego": 3}', "not json"])
def test_a_file_without_a_scene_is_named(text, tmp_path, capsys):
    path = tmp_path / "odd.json"
    path.write_text(text, encoding="utf-8")
    assert main(["prompt", str(path)]) == 2
    assert "odd.json" in capsys.readouterr().err


def test_a_file_that_is_not_there_is_named(tmp_path, capsys):
    assert main(["prompt", str(tmp_path / "none.json")]) == 2
    assert "none.json" in capsys.readouterr().err
