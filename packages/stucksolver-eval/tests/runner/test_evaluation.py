"""Whole evaluations with everything real: the command, processes, servers, drives, criteria and files."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import psutil
import pytest

carla = pytest.importorskip("carla")

import route_crashers  # noqa: E402

from carlette.maps import DEMO_TOWN  # noqa: E402
from stucksolver.commands import main  # noqa: E402
from stucksolver_eval.results.store import ResultStore  # noqa: E402
from stucksolver_eval.routes import Position, Route, RoutePose, ScenarioSpec, write_routes  # noqa: E402
from stucksolver_eval.runner import route_process  # noqa: E402

pytestmark = pytest.mark.integration
LENGTH_M = 90


def straight_ways() -> list[tuple[Position, ...]]:
    """Stretches of the demo town's streets, without a junction."""
    town = carla.Map("demo_town", DEMO_TOWN.read_text(encoding="utf-8"))
    found = []
    for start in town.generate_waypoints(30.0):
        way = [start]
        while len(way) <= LENGTH_M and not way[-1].is_junction and way[-1].next(1.0):
            way.append(way[-1].next(1.0)[0])
        if len(way) > LENGTH_M and not any(w.is_junction for w in way):
            places = [w.transform.location for w in (way[0], way[-1])]
            found.append(tuple(Position(p.x, p.y, p.z) for p in places))
    return found


def suite(folder: Path, count: int, scenario: ScenarioSpec | None = None, town: str = "demo_town") -> Path:
    path = folder / "routes.xml"
    ways = straight_ways()[:count]
    specs = () if scenario is None else (scenario,)
    write_routes(path, [Route(str(k), town, way, (), specs) for k, way in enumerate(ways, 1)])
    return path


def evaluate(suite_file: Path, out: Path, *more: str) -> int:
    return main(["evaluate", "--suite", str(suite_file), "--out", str(out), "--jobs", "2", "--replays", "none", *more])


def records(out: Path) -> dict[str, str]:
    """What must be the same in every run, by file."""
    found = {}
    for path in sorted(out.glob("seed-*/records/*.json")):
        record = json.loads(path.read_text(encoding="utf-8"))["_checkpoint"]["records"][0]
        record["meta"].pop("duration_system")
        found[str(path.relative_to(out))] = json.dumps(record)
    return found


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A suite of two routes, and the folder of its evaluation, which nobody changes."""
    folder = tmp_path_factory.mktemp("plain")
    file = suite(folder, 2)
    assert evaluate(file, folder / "out") == 0
    return file, folder / "out"


@pytest.mark.slow
def test_evaluation_same_seed_is_reproducible_and_resume_repeats_nothing(
    plain: tuple[Path, Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The same seed gives the same records and metrics, and --resume drives only the missing route."""
    file, first = plain
    shutil.copytree(first, tmp_path / "a")
    assert evaluate(file, tmp_path / "b") == 0
    assert len(records(tmp_path / "a")) == 2
    assert records(tmp_path / "a") == records(tmp_path / "b")
    metrics = [(tmp_path / run).glob("seed-1/metrics/*/metric_info.json") for run in "ab"]
    assert [p.read_bytes() for p in sorted(metrics[0])] == [p.read_bytes() for p in sorted(metrics[1])]

    # As if the program had been killed before the second route was over.
    gone = sorted((tmp_path / "a").glob("seed-1/outcomes/*.json"))[1]
    kept = sorted((tmp_path / "a").glob("seed-1/outcomes/*.json"))[0].stat().st_mtime_ns
    gone.unlink()
    capfd.readouterr()
    assert evaluate(file, tmp_path / "a", "--resume") == 0
    told = capfd.readouterr().err
    assert "[2/2]" in told and "[1/2]" not in told
    assert sorted((tmp_path / "a").glob("seed-1/outcomes/*.json"))[0].stat().st_mtime_ns == kept
    assert records(tmp_path / "a") == records(tmp_path / "b")


@pytest.mark.slow
def test_evaluation_reuse_takes_unguided_routes_of_same_system(
    plain: tuple[Path, Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """With --reuse, routes without guidance are taken from an evaluation of the same system; another is rejected."""
    (file, silent), script = plain, tmp_path / "script.json"
    line = {"when": {"time_s": 1.0}, "say": ["go on"], "kind": "helpful"}
    script.write_text(json.dumps({"version": 1, "routes": {"2": [line]}}), encoding="utf-8")
    capfd.readouterr()
    guided = ("--guidance", str(script), "--reuse", str(silent))
    assert evaluate(file, tmp_path / "guided", *guided) == 0
    told = capfd.readouterr().err
    assert "[2/2]" in told and "[1/2]" not in told, told
    assert len(records(tmp_path / "guided")) == 2
    assert len(list((tmp_path / "guided").glob("seed-1/metrics/*/metric_info.json"))) == 2

    assert evaluate(file, tmp_path / "other", *guided, "--recovery", "timers") == 2
    assert "its recovery is 'none', not 'timers'" in capfd.readouterr().err
    assert not (tmp_path / "other").exists()


@pytest.mark.slow
def test_one_crashed_route_is_told_and_the_rest_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(route_process, "_work", route_crashers.crash_on_one)
    assert evaluate(suite(tmp_path, 2), tmp_path / "out") == 1
    store = ResultStore(tmp_path / "out")
    first, second = (store.outcome(route, 1) for route in store.routes())
    assert first is not None and second is not None
    assert (first.state, second.state) == ("crashed", "driven")
    assert first.reason == "its process was killed by SIGSEGV, 2 times in a row"


def test_a_trigger_off_the_route_is_named(tmp_path: Path) -> None:
    far = ScenarioSpec("Far_1", "Accident", RoutePose(Position(5000.0, 0.0, 0.0), 0.0), {"distance": {"value": "40"}})
    assert evaluate(suite(tmp_path, 1, far), tmp_path / "out") == 1
    store = ResultStore(tmp_path / "out")
    outcome = store.outcome(store.routes()[0], 1)
    assert outcome is not None and outcome.state == "invalid"
    assert "Far_1" in outcome.reason and "off the route" in outcome.reason


def test_evaluation_missing_map_is_refused_before_the_first_drive(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line names the towns, the number of routes, the searched folder and the option; nothing is written."""
    assert evaluate(suite(tmp_path, 2, town="Nowhere"), tmp_path / "out", "--maps", str(tmp_path)) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and not (tmp_path / "out").exists()
    assert "no map of Nowhere for 2 of 2 routes" in line and str(tmp_path) in line and "--maps" in line


def test_what_cannot_be_run_is_refused_before_anything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    odd = suite(tmp_path, 1, ScenarioSpec("X_1", "Meteor", RoutePose(Position(0.0, 0.0, 0.0), 0.0), {}))
    cases = [
        ((odd,), "Meteor"),
        ((tmp_path / "none.xml",), "none.xml"),
        (("bench9000",), "bench9000"),
        (("dev", "--recovery", "prayer"), "prayer"),
        (("dev", "--clock", "sundial"), "sundial"),
        (("dev", "--routes", "0"), "no such route in dev: 0"),
        (("dev", "--guidance", str(tmp_path / "none.json")), "none.json"),
        (("dev", "--sweep", "v_min=1"), "no detector to sweep"),
        (("dev", "--recovery", "openai:m@notaurl"), "not an address"),
        (("dev", "--recovery", "openai:m@http://127.0.0.1:9/v1"), "cannot be reached"),
        (("dev", "--recovery", "search", "--reasoner", "openai:m@http://127.0.0.1:9/v1"), "cannot be reached"),
    ]
    for (name, *more), told in cases:
        assert main(["evaluate", "--suite", str(name), "--out", str(tmp_path / "out"), *map(str, more)]) == 2
        assert told in capsys.readouterr().err
        assert not (tmp_path / "out").exists()


def test_evaluation_driven_route_is_complete_with_motion_per_tick(plain: tuple[Path, Path]) -> None:
    """A driven route is complete, and its motion is stored for each tick."""
    store = ResultStore(plain[1])
    route, _ = store.routes()
    record, outcome = store.record(route, 1), store.outcome(route, 1)
    assert record is not None and outcome is not None
    assert (record.status, record.scores.score_route) == ("Completed", 100.0)
    assert len(json.loads(store.metric_info(route, 1).read_text(encoding="utf-8"))) == outcome.ticks + 1
    times = [t for t, _ in outcome.track]
    assert all(0.9 < b - a < 1.1 for a, b in pairwise(times))


@pytest.mark.slow
def test_evaluation_interrupt_leaves_no_process_and_no_crashed_route(tmp_path: Path) -> None:
    """An interrupt leaves no process, and no route counts as crashed."""
    command = [sys.executable, "-c", "from stucksolver.commands import main; raise SystemExit(main())", "evaluate"]
    command += ["--suite", str(suite(tmp_path, 2)), "--out", str(tmp_path / "out"), "--replays", "none"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        of_ours = psutil.Process(process.pid)
        deadline = time.monotonic() + 200
        # Both routes' processes and servers, and Python's own helper.
        while len(begun := of_ours.children(recursive=True)) < 5:
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=200) == 130
        _, left = psutil.wait_procs(begun, timeout=100)
        assert left == []
    finally:
        process.kill()
    assert list((tmp_path / "out").glob("seed-*/outcomes/*")) == []
