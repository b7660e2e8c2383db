"""`stucksolver score` and `stucksolver compare`, on files alone."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from stores import ROUTES, begun, keep, record

from stucksolver.commands import main
from stucksolver_eval.results.outcome import ImmobilizationEpisode, InterventionRecord, Reliability


def evaluation(folder: Path, recovery: str, completion: float) -> Path:
    store = begun(folder, recovery=recovery)
    for of in ROUTES:
        keep(store, of, 1, record(of, completion))
    return folder


def test_score_prints_every_table_and_pairs_with_the_driver_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alone, helped = evaluation(tmp_path / "a", "none", 50.0), evaluation(tmp_path / "b", "rules", 100.0)
    assert main(["score", str(alone), str(helped)]) == 0
    told = capsys.readouterr().out
    assert "driver alone" in told and "driver + rules" in told
    assert "perception:privileged" in told and "Overtaking" in told and "Harm" in told
    assert "with the driver alone" in (helped / "report.html").read_text(encoding="utf-8")


def test_compare_gives_the_difference_with_its_interval(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, second = evaluation(tmp_path / "a", "none", 50.0), evaluation(tmp_path / "b", "rules", 100.0)
    assert main(["compare", str(first), str(second)]) == 0
    told = capsys.readouterr().out
    assert "50.00 [50.00, 50.00]" in told
    assert "won by B: 1 Accident, 2 T_Junction" in told


def test_compare_gives_a_script_the_same_figures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, second = evaluation(tmp_path / "a", "none", 50.0), evaluation(tmp_path / "b", "rules", 100.0)
    assert main(["compare", "--json", str(first), str(second)]) == 0
    [told] = json.loads(capsys.readouterr().out)
    completion = next(figures for figures in told.values() if figures["a"]["mean"] == pytest.approx(50.0))
    assert completion["difference"]["mean"] == pytest.approx(50.0) and completion["pairs"] >= 2


def test_score_gives_a_script_what_summary_json_has(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    alone, helped = evaluation(tmp_path / "a", "none", 50.0), evaluation(tmp_path / "b", "rules", 100.0)
    assert main(["score", "--json", str(alone), str(helped)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [item.pop("folder") for item in told] == [str(alone), str(helped)]
    assert [item.pop("warnings") for item in told] == [[], []]
    assert told == [json.loads((folder / "summary.json").read_text(encoding="utf-8")) for folder in (alone, helped)]
    assert [item["route_completion"] for item in told] == [50.0, 100.0]


def test_a_crashed_route_shows_in_the_exit_code(tmp_path: Path) -> None:
    from stores import outcome

    store = begun(tmp_path / "a")
    store.write_outcome(ROUTES[0], outcome(ROUTES[0], state="crashed", reason="x"))
    assert main(["score", str(store.folder)]) == 1


@pytest.mark.parametrize(("unanswered", "warned"), [(5, False), (6, True)])
def test_score_unreliable_model_warns_in_output_page_and_exit_code(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], unanswered: int, warned: bool
) -> None:
    """A model that leaves more than half of the queries unanswered causes a warning in output, page and exit code."""
    from stores import outcome

    store = begun(tmp_path / "a", recovery="search", reasoner="openai:m")
    told = Reliability(reasoner="openai:m", asked=5, unanswered=unanswered - 1, why="<the server> answered 500")
    rest = Reliability(reasoner="openai:m", asked=5, unanswered=1)
    for of, reliability in zip(ROUTES, (told, rest), strict=True):
        keep(store, of, 1, record(of))
        store.write_outcome(of, outcome(of, points=101, length_m=100.0, reliability=(reliability,)))
    assert main(["score", str(store.folder)]) == int(warned)
    line = f"WARNING: {unanswered} of 10 questions to openai:m had no usable answer"
    assert (line in capsys.readouterr().out) is warned
    assert main(["score", "--json", str(store.folder)]) == int(warned)
    [scored] = json.loads(capsys.readouterr().out)
    assert [text.startswith(line) for text in scored["warnings"]] == [True] * warned
    page = (store.folder / "report.html").read_text(encoding="utf-8")
    assert (line in page) is warned and "<the server>" not in page
    alone, beside = evaluation(tmp_path / "alone", "none", 50.0), tmp_path / "beside.html"
    assert main(["compare", str(alone), str(store.folder), "--page", str(beside)]) == int(warned)
    assert (line in capsys.readouterr().out) is warned and (line in beside.read_text(encoding="utf-8")) is warned


def test_several_runs_are_compared_with_the_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = [evaluation(tmp_path / name, name, percent) for name, percent in (("none", 40.0), ("timers", 60.0))]
    runs.append(evaluation(tmp_path / "rules", "rules", 100.0))
    assert main(["compare", *map(str, runs)]) == 0
    told = capsys.readouterr().out
    assert "20.00 [20.00, 20.00]" in told and "60.00 [60.00, 60.00]" in told


def test_only_the_driver_alone_shows_that_waiting_was_enough(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from stores import outcome

    plan = InterventionRecord(
        start_s=20.0, end_s=25.0, place_m=50.0, rung="rules", behaviors=("nudge",), moves=True, finished=True
    )
    left = ImmobilizationEpisode(onset_s=10.0, place_m=50.0, recovered_after_s=20.0, ended_s=30.0)
    runs = {}
    for name in ("none", "rules", "search"):
        store = begun(tmp_path / name, recovery=name)
        plans = () if name == "none" else (plan,)
        for of in ROUTES:
            keep(store, of, 1, record(of))
            store.write_outcome(of, outcome(of, interventions=plans, spells=(left,)))
        runs[name] = str(store.folder)

    def false(*names: str) -> list[str]:
        capsys.readouterr()
        assert main(["compare", *(runs[name] for name in names)]) == 0
        told = capsys.readouterr().out
        return [line.split()[1:] for line in told.splitlines() if line.startswith("False")]

    assert false("rules", "search") == [["0", "0"]]
    assert false("none", "search") == [["0", "2"]]
    assert false("none", "rules", "search") == [["0", "2"], ["0", "2"]]


@pytest.mark.parametrize("command", [["score", "{}"], ["compare", "{}", "{}"]])
def test_what_is_no_evaluation_is_named(tmp_path: Path, command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([part.format(tmp_path) for part in command]) == 2
    assert "not a result folder of `stucksolver evaluate`" in capsys.readouterr().err


def test_compare_different_routes_error_contains_no_digest(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The error for evaluations of different routes is one line of words, without digests."""
    first, second = evaluation(tmp_path / "a", "none", 50.0), begun(tmp_path / "b", suite_digest="0" * 64).folder
    assert main(["compare", str(first), str(second)]) == 2
    error = capsys.readouterr().err
    assert "different routes: " in error and error.count("\n") == 1
    assert "00000000" not in error


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"suite_digest": "0" * 64, "suite": "dev", "routes": 22}, "the routes differ: 22 of dev there, 2 of"),
        ({"suite_digest": "0" * 64}, "the routes differ: 2 of two on both sides, but not the same ones"),
        ({"guidance": "say.toml", "guidance_digest": "1" * 64}, "the guidance differs: say.toml there, none here"),
        ({"ladder": "l.toml", "ladder_digest": "2" * 64}, "the ladder differs: l.toml there, the usual here"),
        ({"seeds": (1, 2)}, "its seeds"),
    ],
)
def test_what_cannot_be_resumed_is_said_in_words(tmp_path: Path, changes: dict[str, object], told: str) -> None:
    from stucksolver_eval.results.store import StoreError

    store = begun(tmp_path / "a", **changes)
    ours = begun(tmp_path / "b").manifest()
    with pytest.raises(StoreError) as refused:
        store.begin(ours, ROUTES, resume=True)
    assert told in str(refused.value)
    assert "0000" not in str(refused.value) and "1111" not in str(refused.value)


def test_the_limit_on_ticks_is_explained_where_it_is_printed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = begun(tmp_path / "a")
    for of in ROUTES:
        keep(store, of, 1, record(of, 40.0).model_copy(update={"status": "Failed - TickRuntime"}))
    assert main(["score", str(store.folder)]) == 0
    explained = "Failed - TickRuntime (not done after 4000 ticks, 200 s)"
    assert explained in capsys.readouterr().out
    assert explained in (store.folder / "report.html").read_text(encoding="utf-8")
