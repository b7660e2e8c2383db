"""Result files: in the leaderboard's form, never mixed, and all scores come from them alone."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import stores
from stores import CRASH, ROUTES, begun, keep, manifest, metric_info, outcome, record

from stucksolver_eval.criteria import Infraction
from stucksolver_eval.criteria.penalties import KINDS
from stucksolver_eval.metrics.comparison import ComparisonError, comparison
from stucksolver_eval.metrics.summary import Summary, summarize
from stucksolver_eval.report.evaluation import evaluation_page, write_evaluation
from stucksolver_eval.report.tables import summary_json
from stucksolver_eval.results.checkpoint import checkpoint_text
from stucksolver_eval.results.metric_info import NAMES, read_metric_info
from stucksolver_eval.results.outcome import InterventionRecord, SpokenGuidance
from stucksolver_eval.results.store import ResultStore, StoreError

SPEED = Infraction("min_speed_infractions", 1.0, "on average at 80.0% of it", 80.0)


def test_a_checkpoint_has_all_that_the_public_tools_read() -> None:
    text = json.loads(checkpoint_text(record(ROUTES[0], 50.0, "Agent got blocked", SPEED)))
    assert set(text) == {"_checkpoint", "entry_status", "eligible", "sensors", "values", "labels"}
    (found,) = text["_checkpoint"]["records"]
    assert isinstance(found["index"], int)
    assert found["route_id"] == "RouteScenario_1_rep0"
    assert found["status"] == "Failed - Agent got blocked"
    assert tuple(found["infractions"]) == KINDS
    assert found["scores"] == {"score_route": 50.0, "score_penalty": 1.0, "score_composed": 50.0}


def test_perfect_is_only_who_has_no_entry_at_all() -> None:
    assert record(ROUTES[0]).status == "Perfect"
    assert record(ROUTES[0], 100.0, None, SPEED).status == "Completed"


def test_success_forgives_minimum_speed_and_nothing_else() -> None:
    assert record(ROUTES[0], 100.0, None, SPEED).success
    assert not record(ROUTES[0], 100.0, None, CRASH).success
    assert not record(ROUTES[0], 99.0, "TickRuntime").success


def test_motion_is_read_as_it_was_written(tmp_path: Path) -> None:
    metric_info(25).write(tmp_path)
    found = read_metric_info(tmp_path / "metric_info.json")
    assert set(found) == set(NAMES)
    assert all(values.shape == (25, 3) for values in found.values())
    assert found["forward_vector"].tolist() == [[1.0, 0.0, 0.0]] * 25


def test_results_are_not_overwritten(tmp_path: Path) -> None:
    begun(tmp_path / "out")
    with pytest.raises(StoreError, match=r"has results of two .* Add --resume"):
        begun(tmp_path / "out")


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"recovery": "search"}, "recovery is 'none', not 'search'"),
        ({"suite_digest": "0"}, "the routes differ"),
        ({"seeds": (1, 2)}, "seeds is"),
        ({"clock": "latency:2"}, "clock is"),
    ],
)
def test_another_evaluation_is_not_resumed_here(tmp_path: Path, changes: dict[str, object], told: str) -> None:
    store = begun(tmp_path / "out")
    with pytest.raises(StoreError, match=told):
        store.begin(manifest(**changes), ROUTES, resume=True)
    store.begin(manifest(command="another"), ROUTES, resume=True)


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(StoreError, match="not an evaluation and not empty"):
        begun(tmp_path)


def test_results_of_another_version_are_named(tmp_path: Path) -> None:
    store = begun(tmp_path / "out")
    path = store.folder / "evaluation.json"
    path.write_text(path.read_text(encoding="utf-8").replace('"version": 1', '"version": 7'), encoding="utf-8")
    with pytest.raises(StoreError, match="file of another version"):
        store.manifest()


def test_what_is_no_evaluation_is_named(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="not a result folder of"):
        summarize(ResultStore(tmp_path))


def test_result_store_route_is_done_unless_crashed(tmp_path: Path) -> None:
    """A route is done when its outcome is stored and it did not crash."""
    store = begun(tmp_path / "out")
    assert not store.is_done(ROUTES[0], 1)
    store.write_outcome(ROUTES[0], outcome(ROUTES[0], state="crashed"))
    assert not store.is_done(ROUTES[0], 1)
    store.write_outcome(ROUTES[0], outcome(ROUTES[0], state="unsupported"))
    assert store.is_done(ROUTES[0], 1)


def test_missing_routes_count_as_zero(tmp_path: Path) -> None:
    store = begun(tmp_path / "out")
    keep(store, ROUTES[0], 1, record(ROUTES[0], 80.0, "TickRuntime", CRASH))
    found = summarize(store)
    assert (found.driving_score, found.success_rate) == (24.0, 0.0)  # 80 * 0.6 / 2
    assert found.statuses == {"Failed - TickRuntime": 1, "missing": 1}
    assert (found.comfort, found.infraction_score) == (100.0, 0.6)


def test_evaluation_scores_come_from_files_and_cover_every_route(tmp_path: Path) -> None:
    """All scores are computed from the files alone, and the report contains every route."""
    store = begun(tmp_path / "out")
    keep(store, ROUTES[0], 1, record(ROUTES[0], 100.0, None, SPEED))
    store.write_outcome(ROUTES[1], outcome(ROUTES[1], state="crashed", reason="it <b>fell</b> over"))
    report = write_evaluation(store, summarize(store))
    page = report.read_text(encoding="utf-8")
    assert "it &lt;b&gt;fell&lt;/b&gt; over" in page
    assert "reported on CARLA, not comparable" in page
    data = json.loads((store.folder / "summary.json").read_text(encoding="utf-8"))
    assert (data["driving_score"], data["efficiency"]) == (50.0, 80.0)
    assert len((store.folder / "routes.csv").read_text(encoding="utf-8").splitlines()) == 3


def test_recoveries_and_words_are_written_by_kind(tmp_path: Path) -> None:
    store = begun(tmp_path / "out")
    keep(store, ROUTES[0], 1, record(ROUTES[0]))
    plan = InterventionRecord(
        start_s=1.0, end_s=2.0, place_m=0.0, rung="rules", behaviors=("nudge",), moves=True, finished=True
    )
    said = SpokenGuidance(kind="helpful", time_s=0.5, text="go")
    found = outcome(ROUTES[0], interventions=(plan,), guidance=(said,), track=((1.0, 0.0), (2.0, 20.0)))
    store.write_outcome(ROUTES[0], found)
    data = json.loads(summary_json(summarize(store)))["recovery"]
    assert (data["by_rung"], data["said"]) == ({"rules": 1}, {"helpful": 1})


def test_the_page_permits_no_script(tmp_path: Path) -> None:
    page = evaluation_page(summarize(begun(tmp_path / "out")), {})
    assert "default-src 'none'; style-src 'sha256-" in page
    assert "<script" not in page


def test_the_records_folder_holds_checkpoints_only(tmp_path: Path) -> None:
    store = begun(tmp_path / "out")
    keep(store, ROUTES[0], 1, record(ROUTES[0]))
    keep(store, ROUTES[1], 1, record(ROUTES[1]))
    write_evaluation(store, summarize(store))
    texts = [path.read_text(encoding="utf-8") for path in (store.folder / "seed-1" / "records").iterdir()]
    assert len(texts) == 2
    assert all(len(json.loads(text)["_checkpoint"]["records"]) == 1 for text in texts)


def compared(folder: Path, **changes: object) -> Summary:
    store = begun(folder, **changes)
    for of in ROUTES:
        keep(store, of, 1, record(of, 100.0 if changes.get("recovery") == "search" else 50.0))
    return summarize(store)


def test_two_evaluations_are_compared_by_route(tmp_path: Path) -> None:
    first, second = compared(tmp_path / "a"), compared(tmp_path / "b", recovery="search")
    _, _, difference = comparison(first, second)["driving score"]
    assert (difference.difference.mean, difference.pairs) == (50.0, 2)


def test_only_the_same_routes_and_seeds_are_compared(tmp_path: Path) -> None:
    first = compared(tmp_path / "a")
    with pytest.raises(ComparisonError, match="different routes"):
        comparison(first, summarize(begun(tmp_path / "b", suite_digest="0")))
    with pytest.raises(ComparisonError, match="no seed in common"):
        comparison(first, summarize(begun(tmp_path / "c", seeds=(2,))))


def test_this_folder_is_what_the_docs_of_the_store_say(tmp_path: Path) -> None:
    store = begun(tmp_path / "out")
    keep(store, ROUTES[0], 1, record(ROUTES[0]))
    found = {str(path.relative_to(store.folder)) for path in store.folder.rglob("*") if path.is_file()}
    name = "RouteScenario_1_rep0_town_Accident"
    seeded = {f"records/{name}.json", f"metrics/{name}/metric_info.json", f"outcomes/{name}.json"}
    assert found == {"evaluation.json", "routes.xml", *(f"seed-1/{path}" for path in seeded)}
    assert stores.manifest().differs_from(store.manifest()) == ""
