"""`stucksolver prompt` shows what would be sent."""

from __future__ import annotations

import hashlib
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


def recorded(scene, folder, jpeg):
    """A record keeps images as files next to it, with their digest in its lines."""
    digest = hashlib.sha256(jpeg).hexdigest()
    data = scene.model_dump(mode="json") | {"image": {"width": 8, "height": 4, "sha256": digest}}
    path = folder / "record.jsonl"
    path.write_text(json.dumps({"kind": "step", "asked": {"scene": data}}), encoding="utf-8")
    return path, folder / "images" / f"{digest}.jpg"


def test_record_with_an_image_is_shown(scene, tmp_path, capsys):
    path, image = recorded(scene, tmp_path, b"picture")
    image.parent.mkdir()
    image.write_bytes(b"picture")
    assert main(["prompt", str(path)]) == 0
    assert "[front camera, 8x4, 7 bytes of JPEG]" in capsys.readouterr().out


@pytest.mark.parametrize("left", [None, b"changed"])
def test_record_whose_image_is_lost_is_shown_without_it(scene, tmp_path, capsys, left):
    path, image = recorded(scene, tmp_path, b"picture")
    if left is not None:
        image.parent.mkdir()
        image.write_bytes(left)
    assert main(["prompt", str(path)]) == 0
    shown = capsys.readouterr()
    assert ROLE in shown.out and "front camera," not in shown.out and "note: shown without the image" in shown.err


@pytest.mark.parametrize("text", ["", "{}", '{"ego": 3}', "not json"])
def test_a_file_without_a_scene_is_named(text, tmp_path, capsys):
    path = tmp_path / "odd.json"
    path.write_text(text, encoding="utf-8")
    assert main(["prompt", str(path)]) == 2
    assert "odd.json" in capsys.readouterr().err


def test_a_file_that_is_not_there_is_named(tmp_path, capsys):
    assert main(["prompt", str(tmp_path / "none.json")]) == 2
    assert "none.json" in capsys.readouterr().err
