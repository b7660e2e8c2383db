"""The table of passes refused for want of sight, from records as the guard's verdicts are written to them."""

from __future__ import annotations

import json

import pytest

from stucksolver.guard import RejectCode, RejectReason, Verdict
from stucksolver_eval.result_pages.refused_passes import main


def written(folder, *rejects):
    folder.mkdir(parents=True, exist_ok=True)
    lines = [{"kind": "step", "told": [{"judged": Verdict(rejects=(r,)).model_dump(mode="json")}]} for r in rejects]
    (folder / "intervention-0001.jsonl").write_text("\n".join(json.dumps(x) for x in lines), encoding="utf-8")


def sight(needed_m, seen_m):
    facts = {"needed_m": needed_m, "seen_m": seen_m, "time_s": 7.3, "gap_m": seen_m - needed_m}
    return RejectReason(code=RejectCode.ONCOMING_SIGHT, detail="any words", **facts)


def test_each_route_shows_the_refusal_that_lacked_the_least(tmp_path, capsys):
    other = RejectReason(code=RejectCode.ONCOMING_GAP, detail="oncoming_sight")
    written(tmp_path / "route b", sight(200.0, 100.0), other, sight(150.0, 120.0), sight(160.0, 90.0))
    written(tmp_path / "route a", sight(99.0, 10.0))
    written(tmp_path / "route c", other)
    assert main([str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines()[2:] == [
        "| route a | 99 | 10 | 7.3 | 79 |",
        "| route b | 150 | 120 | 7.3 | 79 |",
    ]


def test_a_folder_without_records_is_named_with_the_remedy(tmp_path, capsys):
    with pytest.raises(SystemExit) as stopped:
        main([str(tmp_path)])
    assert stopped.value.code == 2 and "--record" in capsys.readouterr().err
