"""`stucksolver memory`: everything can be read, taken along and deleted; what is wrong is one line."""

from __future__ import annotations

import io
import json
import time

import pytest
from remembering import BACK_UP, episode

from stucksolver.commands import main
from stucksolver_eval.systems import SystemSpecError
from stucksolver_eval.systems.factory import check_arm
from stucksolver_eval.systems.spec import SystemSpec
from stucksolver_passenger.memory import SolutionOutcome, SolutionStore

HOSTILE = "\x1b[31mred\x1b[0m\nline two"


@pytest.fixture
def file(tmp_path):
    store = SolutionStore(tmp_path / "m.db")
    store.add(episode(text="take another street", at_s=time.time() - 40 * 86_400))
    store.add(episode(BACK_UP, SolutionOutcome.FAILED, text=HOSTILE, at_s=time.time(), vehicle="car-2"))
    return str(tmp_path / "m.db")


def said(capsys, *arguments):
    assert main(["memory", *arguments]) == 0
    return capsys.readouterr().out


def refused(capsys, *arguments):
    assert main(["memory", *arguments]) == 2
    told = capsys.readouterr()
    assert told.out == "" and told.err.count("\n") == 1, told.err
    return told.err


def test_list_has_a_line_for_each_and_no_control_characters(capsys, file):
    first, second = said(capsys, "list", file).splitlines()
    assert '"take another street" → reroute: worked' in first and "debris, standing" in first
    assert "back up: failed" in second and "\x1b" not in second


def test_list_show_and_export_are_json_that_has_everything(capsys, file):
    listed = [json.loads(line) for line in said(capsys, "list", file, "--json").splitlines()]
    shown = json.loads(said(capsys, "show", file, "2"))
    assert listed[1] == shown and shown["text"] == HOSTILE and shown["ending"] == "failed"
    assert json.loads(said(capsys, "export", file).splitlines()[0])["text"] == "take another street"


def test_what_was_exported_can_be_imported(capsys, file, tmp_path, monkeypatch):
    lines = said(capsys, "export", file)
    (tmp_path / "lines").write_text(lines, encoding="utf-8")
    assert said(capsys, "import", str(tmp_path / "new.db"), str(tmp_path / "lines")) == "2 added\n"
    monkeypatch.setattr("sys.stdin", io.StringIO(lines))
    assert said(capsys, "import", str(tmp_path / "new.db"), "-") == "2 added\n"
    assert said(capsys, "export", str(tmp_path / "new.db")) == lines * 2


def test_import_and_forget_give_a_script_their_counts(capsys, file, tmp_path):
    (tmp_path / "lines").write_text(said(capsys, "export", file), encoding="utf-8")
    new = str(tmp_path / "new.db")
    assert json.loads(said(capsys, "import", new, str(tmp_path / "lines"), "--json")) == {"added": 2}
    assert json.loads(said(capsys, "forget", new, "1", "--json")) == {"forgotten": 1}


def test_a_bad_line_is_named_and_nothing_is_added(capsys, file, tmp_path):
    (tmp_path / "lines").write_text(said(capsys, "export", file) + '{"ending": "worked"}\n', encoding="utf-8")
    told = refused(capsys, "import", str(tmp_path / "new.db"), str(tmp_path / "lines"))
    assert "line 3. Nothing was added" in told
    assert not (tmp_path / "new.db").exists()


@pytest.mark.parametrize(
    ("which", "left"), [(["1"], [2]), (["--days", "30"], [2]), (["--vehicle", "car-2"], [1]), (["--all"], [])]
)
def test_forget_deletes_what_was_named_and_nothing_else(capsys, file, tmp_path, which, left):
    said(capsys, "forget", file, *which)
    assert [kept.number for kept in SolutionStore(tmp_path / "m.db").episodes()] == left


def test_what_cannot_be_done_is_one_line_with_the_remedy(capsys, file, tmp_path):
    (tmp_path / "diary").write_text("dear diary " * 400, encoding="utf-8")
    assert "no such memory" in refused(capsys, "list", str(tmp_path / "nowhere.db"))
    assert "not a StuckSolver memory" in refused(capsys, "list", str(tmp_path / "diary"))
    assert "no such entry: 9" in refused(capsys, "show", file, "9")
    assert "nothing selected" in refused(capsys, "forget", file)


def test_system_with_invalid_memory_file_is_rejected_before_run(tmp_path):
    """A system whose memory is another file, or which has no recovery to use it, is rejected before the run."""
    (tmp_path / "diary").write_text("dear diary " * 400, encoding="utf-8")
    with pytest.raises(SystemSpecError, match="not a StuckSolver memory"):
        check_arm(SystemSpec(recovery="search", memory=tmp_path / "diary"))
    with pytest.raises(SystemSpecError, match="'none' does not"):
        check_arm(SystemSpec(memory=tmp_path / "m.db"))
