"""A client records into one folder, whatever it names."""

from __future__ import annotations

from pathlib import Path

import pytest

from carlette.errors import RequestError
from carlette.recorder import default_folder, make_room, path_in


@pytest.mark.parametrize("name", ["run.log", "monday/run.log", "./run.log"])
def test_a_name_within_the_folder_is_taken_relative_or_absolute(tmp_path: Path, name: str) -> None:
    assert path_in(tmp_path, name) == tmp_path / name
    assert path_in(tmp_path, str(tmp_path / name)) == tmp_path / name


@pytest.mark.parametrize("name", ["", ".", "..", "../run.log", "a/../run.log", "/etc/passwd", "a\0b"])
def test_what_leads_elsewhere_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(RequestError, match=r"give (one|a name) such as run\.log"):
        path_in(tmp_path, name)


def test_a_link_leads_nowhere_else_either(tmp_path: Path) -> None:
    folder, outside = tmp_path / "logs", tmp_path / "outside"
    folder.mkdir()
    outside.mkdir()
    (folder / "door").symlink_to(outside)
    with pytest.raises(RequestError, match="is not a file within"):
        path_in(folder, "door/run.log")


def test_the_folder_comes_into_being_with_the_first_log(tmp_path: Path) -> None:
    make_room(tmp_path / "a" / "b" / "run.log")
    assert (tmp_path / "a" / "b").is_dir()
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.raises(RequestError, match="start the server with another --recordings"):
        make_room(tmp_path / "file" / "run.log")


def test_the_default_is_in_the_users_folder_for_state(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert default_folder() == tmp_path / "carlette" / "recordings"
