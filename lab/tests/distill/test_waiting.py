"""Collecting with the driver alone: what a folder holds, and that a second run continues it."""

from __future__ import annotations

import pytest

from lab.commands import COMMANDS
from lab.language.plan_search.counterfactual_run import DriveSpec
from lab.language.plan_search.decision_samples import read_moments
from lab.language.plan_search.wait_samples import WaitingError, WaitingSpec, collect_waits
from stucksolver.commands import main
from stucksolver.record import Recorder
from stucksolver_eval.suites import load_routes
from stucksolver_language.student.scene_codec import read_scene
from worlds import World, drive, straight_road, thing


def collected(out, *, routes, seeds=(1,), limit_s=25.0):
    told: list[str] = []
    spec = WaitingSpec("dev", load_routes("dev", routes), seeds, out, jobs=1, drives=DriveSpec(limit_s=limit_s))
    failed = collect_waits(spec, told.append)
    assert failed == []
    return told


@pytest.mark.integration
@pytest.mark.release
def test_a_drive_is_kept_as_moments_and_never_driven_twice(tmp_path):
    route = load_routes("dev")[0].id
    assert len(collected(tmp_path, routes=(route,))) == 1
    (path,) = (tmp_path / "moments" / "dev").iterdir()
    found = read_moments(path)
    assert found, "a vehicle stands at the start of its route"
    assert all(item.watched_s <= 25.0 for item in found)
    judged = [plan for item in found for plan in item.plans]
    assert any(plan.value_m is None for plan in judged)
    for item in found:
        assert item.scenario not in item.scene, "labels never reach a scene"
        assert read_scene(item.scene).behaviors
    assert not (tmp_path / "drives").exists(), "nothing else is kept"
    before = path.read_bytes()
    assert collected(tmp_path, routes=(route,)) == []
    assert path.read_bytes() == before
    with pytest.raises(WaitingError, match="other options"):
        collected(tmp_path, routes=(route,), limit_s=30.0)


@pytest.mark.integration
def test_the_answers_of_a_record_are_kept_with_their_scenes(tmp_path):
    record = Recorder(tmp_path / "records")
    drive(World(straight_road(), [thing("lead", 62.0)]), 40.0, record=record)
    assert (
        main(
            ["distill", "collect", "--records", str(tmp_path / "records"), "--out", str(tmp_path / "out")],
            table=COMMANDS,
        )
        == 0
    )
    (path,) = (tmp_path / "out" / "moments" / "records").iterdir()
    found = read_moments(path)
    assert any(item.answer is not None and item.answer.plan is not None for item in found)
    assert all(read_scene(item.scene).objects[0].id == "lead" for item in found)


def test_a_folder_without_records_is_named(tmp_path, capsys):
    assert main(["distill", "collect", "--records", str(tmp_path), "--out", str(tmp_path / "out")], table=COMMANDS) == 2
    assert "no record of an intervention" in capsys.readouterr().err


def test_scoring_without_moments_says_what_to_do(tmp_path, capsys):
    assert main(["distill", "eval", "--data", str(tmp_path), "--out", str(tmp_path / "out")], table=COMMANDS) == 2
    assert "distill collect --waits" in capsys.readouterr().err


def test_exported_weights_are_checked_first(tmp_path, capsys):
    assert main(["distill", "export", "--weights", str(tmp_path), "--out", str(tmp_path / "out")], table=COMMANDS) == 2
    assert "no student in folder" in capsys.readouterr().err
