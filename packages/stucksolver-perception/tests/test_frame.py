"""One moment of a recording is drawn; a moment that was not recorded is refused with those that were."""

from __future__ import annotations

import pytest
from PIL import Image
from tests.lidar.synthetic import drive

from lab.perception.evaluation.draw_frame import DPI, SIZE_IN, main, spread
from lab.perception.evaluation.scoring.samples import looks_of
from stucksolver_perception.recording import Recording

pytest.importorskip("matplotlib", reason="needs matplotlib (the extra `report`)")
pytest.importorskip("filterpy", reason="needs filterpy (the extra `perception`)")


@pytest.fixture
def recording(tmp_path):
    """A drive of 1.2 s without pictures."""
    drive(tmp_path / "drive", 1, ticks=25)
    return tmp_path / "drive"


def frame(data, at, out):
    return main(["--data", str(data), f"--at={at}", "--out", str(out)])


@pytest.mark.slow
def test_a_moment_is_drawn(recording, tmp_path, capsys):
    out = tmp_path / "new" / "moment.png"
    assert frame(recording, 1.0, out) == 0
    assert capsys.readouterr().out.strip() == str(out)
    picture = Image.open(out)
    assert picture.size == tuple(round(side * DPI) for side in SIZE_IN)
    assert len(picture.getcolors()) > 50


@pytest.mark.parametrize("at", ["-1", "1.3", "99", "nan"])
def test_frame_time_not_recorded_is_rejected_with_range(recording, tmp_path, capsys, at):
    """A time that was not recorded is rejected with the recorded ones."""
    assert frame(recording, at, tmp_path / "no.png") == 2
    assert f"--at: expected 0 to 1.2 s, got {at} " in capsys.readouterr().err
    assert not (tmp_path / "no.png").exists()


def test_a_folder_that_is_no_recording_is_named(tmp_path, capsys):
    assert frame(tmp_path / "nothing", 1.0, tmp_path / "no.png") == 2
    assert f"{tmp_path / 'nothing'}: this folder is not a recording" in capsys.readouterr().err


def test_each_look_has_the_ticks_since_the_look_before(recording):
    looks = [[round(tick.time_s / 0.05) for tick in ticks] for ticks in looks_of(Recording(recording))]
    assert looks[:3] == [[0], [1, 2], [3, 4]]
    assert looks[-1] == [23, 24]


def test_spread_labels_do_not_overlap_and_stay_inside():
    placed = spread([-1.0, 4.0, 4.1, 9.9, 10.0], 1.0, 0.0, 10.0)
    assert placed == pytest.approx([0.0, 4.0, 5.0, 9.0, 10.0])
