"""The pages of evaluations: every figure is explained where it stands, and runs are compared side by side."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from stores import CRASH, ROUTES, begun, keep, outcome, record

from stucksolver.record import RecordError
from stucksolver.record.hash_chain import ChainWriter
from stucksolver_eval.metrics.columns import RECOVERY_HEAD
from stucksolver_eval.metrics.comparison import ComparisonError
from stucksolver_eval.metrics.summary import summarize
from stucksolver_eval.report.comparison import column_names, write_comparison
from stucksolver_eval.report.decisions import moments_of
from stucksolver_eval.report.evaluation import evaluation_page, write_evaluation
from stucksolver_eval.report.metric_tables import RECOVERY_MEANINGS
from stucksolver_eval.report.tables import reaction_text, summary_data

DECISION = {
    "version": 1,
    "observation": {"controls": [], "participants": [], "summary": "a van"},
    "analysis": {"steps": [], "immobilized": True, "cause": "parked_vehicle", "reason": "it is parked"},
    "plan": None,
    "rationale": "wait: a <b>van</b> comes",
}


def test_evaluation_page_explains_scores_and_folds_published_ones(tmp_path: Path) -> None:
    """Every score is explained where it is, and published scores of others are marked and folded."""
    store = begun(tmp_path / "out")
    keep(store, ROUTES[0], 1, record(ROUTES[0], 80.0, "TickRuntime", CRASH))
    page = evaluation_page(summarize(store), {})
    for name in ("Driving score (DS)", "Success rate (SR)", "Route completion (RC)", "Infraction score (IS)"):
        assert name in page
    assert "route completion times infraction score" in page
    assert "TickRuntime (not done after 4000 ticks, 200 s)" in page
    assert "<details><summary>Published figures, reported on CARLA, not comparable</summary>" in page
    assert 'name="viewport"' in page and "<main>" in page and 'lang="en"' in page


def test_each_recovery_figure_has_a_meaning() -> None:
    assert set(RECOVERY_MEANINGS) == set(RECOVERY_HEAD[1:])


def test_comparison_page_lists_routes_with_different_results(tmp_path: Path) -> None:
    """Runs are compared side by side, with the routes on which their results differ."""
    stores = [begun(tmp_path / name, recovery=name) for name in ("none", "rules")]
    keep(stores[0], ROUTES[0], 1, record(ROUTES[0], 50.0, "Agent got blocked"))
    keep(stores[1], ROUTES[0], 1, record(ROUTES[0], 100.0, None))
    for store in stores:
        keep(store, ROUTES[1], 1, record(ROUTES[1], 100.0, None))
    write_comparison([s.folder for s in stores], [summarize(s) for s in stores], tmp_path / "pages" / "all.html")
    page = (tmp_path / "pages" / "all.html").read_text(encoding="utf-8")
    assert "Differences to driver alone" in page and "driver + rules: driving score" in page
    assert "25.00 [" in page, "the mean difference over both routes"
    ended = page.split("Drives that ended differently")[2]
    assert ended.count("<tr>") == 2, "the head, and the one route on which they differ"
    assert "Agent got blocked, 50.0" in ended and "success, 100.0" in ended


def test_runs_of_one_name_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    folders = [tmp_path / "monday", tmp_path / "tuesday"]
    found = [summarize(begun(folder)) for folder in folders]
    assert column_names(found, folders) == ["driver alone (monday)", "driver alone (tuesday)"]


def test_runs_of_other_routes_are_not_compared(tmp_path: Path) -> None:
    folders = [tmp_path / "a", tmp_path / "b"]
    found = [summarize(begun(folders[0])), summarize(begun(folders[1], suite_digest="0"))]
    with pytest.raises(ComparisonError, match="different routes"):
        write_comparison(folders, found, tmp_path / "page.html")


def recorded(folder: Path) -> Path:
    """The record of an intervention with one decision, which came in with the line that tells of it."""
    chain = ChainWriter(folder / "intervention-0001.jsonl")
    chain.write({"kind": "begin"})
    told = {"event": {"time_s": 12.345, "kind": "decided", "text": "wait", "trigger": "speed"}}
    chain.write({"kind": "step", "in": {"answer": {"reasoner": "rules", "decision": DECISION}}, "told": [told]})
    chain.close()
    return chain.path


def test_decisions_are_read_from_records_where_no_replay_was_kept(tmp_path: Path) -> None:
    store = begun(tmp_path / "out")
    keep(store, ROUTES[0], 1, record(ROUTES[0]))
    recorded(store.interventions(ROUTES[0], 1))
    page = write_evaluation(store, summarize(store)).read_text(encoding="utf-8")
    (written,) = store.interventions(ROUTES[0], 1).glob("*.html")
    assert f'href="{written.relative_to(store.folder)}"' in page
    text = written.read_text(encoding="utf-8")
    data = json.loads(text.split('id="data">')[1].split("</script>")[0])
    (moment,) = data["runs"][0]["decisions"]
    assert (moment["time_s"], moment["decision"]["rationale"]) == (12.35, DECISION["rationale"])
    assert "<b>van" not in text


def test_a_record_that_was_changed_is_told(tmp_path: Path) -> None:
    path = recorded(tmp_path)
    path.write_text(path.read_text(encoding="utf-8").replace("van", "bus"), encoding="utf-8")
    with pytest.raises(RecordError, match="line 2"):
        list(moments_of(tmp_path))


def test_reactions_are_listed_where_they_have_a_time_limit(tmp_path: Path) -> None:
    """The terminal, the page and summary.json show each situation with right or wrong; other suites have no list."""
    store = begun(tmp_path)
    keep(store, ROUTES[0], 1, record(ROUTES[0]))
    assert reaction_text(summarize(store)) == ""
    asked = outcome(ROUTES[0], expected="ask", within_s=30.0, marks={"met": 10.0}, asked_s=60.0)
    store.write_outcome(ROUTES[0], asked)
    summary = summarize(store)
    assert "0 of 1 reactions right; operator called after 50 s" in reaction_text(summary)
    assert "0/1 Accident (ask within 30 s)" in " ".join(reaction_text(summary).split())
    assert summary_data(summary)["reactions"][0]["faults"] == ("told an operator after 50 s",)
    assert "Right reactions" in evaluation_page(summary, {})
