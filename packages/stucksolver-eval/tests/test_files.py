"""Results are written whole or not at all, and what goes wrong is told with the file's name."""

from __future__ import annotations

import contextlib
import os
import resource
from collections.abc import Iterator
from pathlib import Path

import pytest

from stucksolver.atomic_files import OutputError, require_writable, write_text

PLENTY = "x" * 100_000


@contextlib.contextmanager
def full_disk() -> Iterator[None]:
    """No file may grow beyond a few bytes, as on a disk without room: nor may the one that pytest's output goes to."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_folders_are_made_and_the_text_is_there(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b" / "log.json"
    write_text(path, "größer\n")
    assert path.read_text(encoding="utf-8") == "größer\n"
    assert os.listdir(path.parent) == ["log.json"]


def test_write_text_replaces_atomically_with_umask_permissions(tmp_path: Path) -> None:
    """A file is replaced in one step, and its permissions follow the umask."""
    path = tmp_path / "log.json"
    path.write_text("old", encoding="utf-8")
    with path.open() as before:
        mask = os.umask(0o022)
        write_text(path, "new")
        os.umask(mask)
        assert (before.read(), path.read_text(encoding="utf-8")) == ("old", "new")
    assert path.stat().st_mode & 0o777 == 0o644


def test_a_full_disk_is_told_and_the_old_file_kept(tmp_path: Path) -> None:
    path = tmp_path / "log.json"
    path.write_text("old", encoding="utf-8")
    with pytest.raises(OutputError) as told, full_disk():
        write_text(path, PLENTY)
    assert str(path) in str(told.value) and "File too large" in str(told.value)
    assert path.read_text(encoding="utf-8") == "old"
    assert os.listdir(tmp_path) == ["log.json"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_write_text_without_permission_keeps_old_file(tmp_path: Path) -> None:
    """A folder without write permission is reported, and the old file stays."""
    path = tmp_path / "log.json"
    path.write_text("old", encoding="utf-8")
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(OutputError, match="Permission denied"):
            write_text(path, "new")
        with pytest.raises(OutputError, match="Permission denied"):
            require_writable(tmp_path)
    finally:
        tmp_path.chmod(0o700)
    assert path.read_text(encoding="utf-8") == "old"


def test_a_file_where_a_folder_should_be_is_told(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("I am a file", encoding="utf-8")
    path = tmp_path / "out" / "log.json"
    for attempt in (lambda: write_text(path, "new"), lambda: require_writable(path.parent)):
        with pytest.raises(OutputError) as told:
            attempt()
        assert str(tmp_path / "out") in str(told.value)
    assert (tmp_path / "out").read_text(encoding="utf-8") == "I am a file"


def test_write_text_onto_folder_fails_without_leftovers(tmp_path: Path) -> None:
    """A folder at the path of the file is reported, and no temporary file remains."""
    (tmp_path / "log.json").mkdir()
    with pytest.raises(OutputError, match=r"log\.json"):
        write_text(tmp_path / "log.json", "new")
    assert os.listdir(tmp_path) == ["log.json"]


def test_a_place_that_no_one_can_write_to_is_told() -> None:
    with pytest.raises(OutputError, match="/proc/nowhere"):
        require_writable(Path("/proc/nowhere"))


def test_seeing_whether_a_folder_is_writable_leaves_nothing_in_it(tmp_path: Path) -> None:
    require_writable(tmp_path / "out" / "runs")
    assert os.listdir(tmp_path / "out" / "runs") == []
