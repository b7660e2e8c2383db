"""Files that only their owner may read: new ones from the start, and those that were there before."""

from __future__ import annotations

import os
import stat

import pytest

from stucksolver.privacy.private_files import append, make_private, open_new, write_once


@pytest.fixture(autouse=True, params=[0o000, 0o022, 0o077], ids=oct)
def umask(request):
    """Whatever the user's mask is."""
    before = os.umask(request.param)
    yield
    os.umask(before)


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


def test_new_file_is_its_owners(tmp_path):
    with open_new(tmp_path / "new") as file:
        assert mode(tmp_path / "new") == 0o600
        file.write(b"x")
    with pytest.raises(FileExistsError):
        open_new(tmp_path / "new")


@pytest.mark.parametrize("before", [None, 0o644, 0o666, 0o600])
def test_file_that_is_appended_to_becomes_its_owners(tmp_path, before):
    path = tmp_path / "old"
    if before is not None:
        path.write_bytes(b"a")
        path.chmod(before)
    append(path, b"b")
    assert mode(path) == 0o600
    assert path.read_bytes() == (b"b" if before is None else b"ab")


@pytest.mark.parametrize("before", [None, 0o644, 0o600])
def test_file_that_is_written_once_becomes_its_owners(tmp_path, before):
    path = tmp_path / "digest.jpg"
    if before is not None:
        path.write_bytes(b"first")
        path.chmod(before)
    write_once(path, b"second")
    assert mode(path) == 0o600
    assert path.read_bytes() == (b"second" if before is None else b"first")
    assert list(tmp_path.iterdir()) == [path]


def test_make_private_keeps_a_stricter_mode(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"x")
    path.chmod(0o400)
    make_private(path)
    assert mode(path) == 0o400
