"""`python -m lab perception` refuses what cannot be done, before anything is done."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import pytest

from lab.commands import COMMANDS
from lab.commands.perception import SCORED, TRAINED
from lab.perception.evaluation.scoring.evaluate import PARTS
from lab.perception.training.train_networks import NETWORKS, TrainingError, export_networks
from stucksolver.commands import main


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(["perception", *words], table=COMMANDS) == 2
    return capsys.readouterr().err


def test_the_parts_that_are_offered_are_those_that_there_are() -> None:
    assert tuple(PARTS) == SCORED
    assert tuple(NETWORKS) == TRAINED


def test_windows_cannot_overlap(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert "--every" in refused(capsys, "collect", "--suite", "dev", "--out", str(tmp_path), "--every", "0.3")


def test_an_unknown_suite_and_an_unknown_part_are_named(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert "nowhere" in refused(capsys, "collect", "--suite", "nowhere", "--out", str(tmp_path))
    assert "radar" in refused(capsys, "eval", "--data", str(tmp_path), "--out", str(tmp_path), "--only", "radar")


def test_a_folder_without_recordings_is_named_with_the_remedy(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    said = refused(capsys, "eval", "--data", str(tmp_path), "--out", str(tmp_path / "scores"))
    assert str(tmp_path) in said and "perception collect" in said


@pytest.mark.skipif(find_spec("torch") is not None, reason="torch is here")
def test_without_torch_training_says_how_to_get_it(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = str(tmp_path)
    assert "pip install torch" in refused(capsys, "train", "--data", folder, "--check", folder, "--out", folder)


def test_trained_files_are_copied_and_a_missing_one_is_named(tmp_path: Path) -> None:
    run, to = tmp_path / "run" / "far", tmp_path / "to"
    run.mkdir(parents=True)
    (run / "far.onnx").write_bytes(b"1")
    with pytest.raises(TrainingError, match=r"far\.json"):
        export_networks(tmp_path / "run", (), to, ())
    (run / "far.json").write_text("{}", encoding="utf-8")
    assert export_networks(tmp_path / "run", (), to, ("far",)) == [to]
    assert (to / "far.onnx").read_bytes() == b"1"
