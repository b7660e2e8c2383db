"""Records that an earlier version wrote, before modules and fields were renamed, replay to the last value."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from stucksolver.record import replay

FORMER = sorted((Path(__file__).parent / "former").glob("*.jsonl.gz"))
"""Written at 6f68d986 by three drives of the small test world: a pass, refused plans at a solid line, a bicycle."""


@pytest.mark.parametrize("path", FORMER, ids=lambda path: path.stem)
def test_replay_former_record_matches(path, tmp_path):
    file = tmp_path / path.stem
    file.write_bytes(gzip.decompress(path.read_bytes()))
    report = replay(file)
    assert report.matches, report.findings
    assert not report.texts_compared
    assert report.ticks > 100


def test_former_records_are_there():
    assert len(FORMER) == 3
