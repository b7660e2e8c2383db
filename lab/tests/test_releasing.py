"""What a release is checked for: licenses, and which Python is found."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from lab.benchmarks.against import MAX_FACTOR, slower
from lab.releasing.__main__ import find_python
from lab.releasing.licenses import allowed


@pytest.mark.parametrize(
    "license",
    ["MIT", "BSD-3-Clause AND 0BSD AND MIT AND Zlib AND CC0-1.0", "Apache-2.0 OR BSD-2-Clause", "MPL-2.0 AND MIT"],
)
def test_licenses_that_leave_our_code_alone_are_allowed(license):
    assert allowed(license)


@pytest.mark.parametrize(
    "license", ["", "GPL-3.0-only", "MIT AND AGPL-3.0-or-later", "LGPL-2.1", "Proprietary", "UNKNOWN"]
)
def test_others_and_none_at_all_are_refused(license):
    assert not allowed(license)


def test_a_python_that_is_not_here_is_not_made_up(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("PYENV_ROOT", str(tmp_path))
    assert find_python("3.11") is None
    (tmp_path / "python3.11").write_text("#!/bin/sh\necho 3.9\n", encoding="utf-8")
    (tmp_path / "python3.11").chmod(0o755)
    assert find_python("3.11") is None, "one by that name that is another"
    (tmp_path / "python3.11").write_text("#!/bin/sh\necho 3.11\n", encoding="utf-8")
    assert find_python("3.11") == str(tmp_path / "python3.11")


def test_benchmark_large_slowdown_is_reported_and_small_is_not():
    """A value that is much slower than the baseline is reported, as is one that is missing; a small slowdown is not."""
    before = {"us_step": 2.0, "us_accept": 100.0}
    assert slower({"us_step": 2.0 * MAX_FACTOR, "us_accept": 30.0}, before) == []
    [told] = slower({"us_step": 2.0, "us_accept": 101.0 * MAX_FACTOR}, before)
    assert told.startswith("us_accept: 2.5 times")
    assert slower({"us_step": 2.0}, before) == ["us_accept: no longer measured; if this is intended, run --keep"]


ROOT = Path(__file__).parents[2]


def test_citation_has_required_fields_and_last_release():
    """The citation file has the fields that its format requires, and names the last release."""
    told = pytest.importorskip("yaml").safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors", "license", "version"} <= set(told)
    last = re.search(r"^## \[?(\d[^\s\]]*)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert last is not None and str(told["version"]) == last[1]


def test_no_lock_file_carries_an_address():
    for lock in (ROOT / "requirements").glob("*.txt"):
        assert not re.search(r"://|--index|--find-links", lock.read_text(encoding="utf-8")), lock.name
