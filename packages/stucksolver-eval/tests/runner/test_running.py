"""The runner without a simulator: parallel, watched, and what it is asked for."""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("carla")

from stucksolver.atomic_files import OutputError
from stucksolver_eval.results.checkpoint import make_record
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.routes import Position, Route, RoutePose, ScenarioSpec, WeatherKey
from stucksolver_eval.runner.evaluate import EvaluationSpec
from stucksolver_eval.runner.immobilization_watch import ImmobilizationWatch
from stucksolver_eval.runner.isolated_process import RunCancelledError
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.pool import run_tasks
from stucksolver_eval.runner.progress import ProgressDisplay
from stucksolver_eval.runner.route_process import RouteTask, run_task
from stucksolver_eval.runner.sweep import SweepError, parse_sweep, sweep_specs
from stucksolver_eval.runner.weather import between
from stucksolver_eval.systems.spec import SystemSpec

HERE = Position(0.0, 0.0, 0.0)


def task(number: int) -> RouteTask:
    spec = ScenarioSpec("a", "Accident", RoutePose(HERE, 0.0), {})
    return RouteTask(RouteJob(Route(str(number), "t", (HERE, HERE), (), (spec,)), 1, SystemSpec()), Path("x"))


def outcome_of(one: RouteTask, **changes: Any) -> RouteOutcome:
    return RouteOutcome(route_id=one.job.route.id, scenario="Accident", town="t", seed=1, arm="", **changes)


def test_run_tasks_reports_each_once_and_runs_in_parallel() -> None:
    """Each task is reported once, and as many run at a time as requested."""
    together = threading.Barrier(3, timeout=100)

    def runner(one: RouteTask, progress: Callable[[float], None], wanted: Callable[[], bool]) -> RouteOutcome:
        progress(1.0)
        together.wait()
        return outcome_of(one)

    news = list(run_tasks([task(k) for k in range(6)], 3, runner))
    assert sorted(n.task.job.route.id for n in news if n.outcome is not None) == list("012345")
    assert sum(n.outcome is None for n in news) == 6


def test_a_full_disk_stops_everything() -> None:
    def runner(one: RouteTask, progress: Callable[[float], None], wanted: Callable[[], bool]) -> RouteOutcome:
        raise OutputError("no room")

    with pytest.raises(OutputError, match="no room"):
        list(run_tasks([task(1), task(2)], 2, runner))


def test_who_stops_listening_goes_on_when_all_have_ended() -> None:
    ended: list[str] = []

    def runner(one: RouteTask, progress: Callable[[float], None], wanted: Callable[[], bool]) -> RouteOutcome:
        progress(1.0)
        while wanted():
            time.sleep(0.01)
        time.sleep(0.2)
        ended.append(one.job.route.id)
        raise RunCancelledError

    listening = run_tasks([task(k) for k in range(5)], 2, runner)
    next(listening)
    listening.close()
    assert sorted(ended) == ["0", "1"]


def test_what_is_not_wanted_is_not_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that was killed by the end of all is not tried once more."""
    monkeypatch.setattr("multiprocessing.process.BaseProcess.start", lambda self: pytest.fail("a process was begun"))
    with pytest.raises(RunCancelledError):
        run_task(task(1), wanted=lambda: False)


def test_progress_without_terminal_prints_plain_line_per_route() -> None:
    """Without a terminal, the display prints one line for each route and no escape sequences."""
    out = io.StringIO()
    board = ProgressDisplay(total=3, before=1, out=out, now=lambda: 0.0)
    board.goes_on(task(1), 10.0)
    record = make_record(
        route_id="1",
        scenario="Accident",
        town="t",
        length_m=100.0,
        game_s=10.0,
        wall_s=1.0,
        completion_pct=100.0,
        failure=None,
        infractions=(),
    )
    board.is_over(task(1), outcome_of(task(1), ticks=200, wall_s=2.0), record)
    board.is_over(task(2), outcome_of(task(2), state="crashed", reason="first\nlast words"), None)
    board.close()
    assert out.getvalue().splitlines() == [
        "[2/3] 1 Accident (seed 1): Perfect, DS 100.0 (100 ticks/s)",
        "[3/3] 2 Accident (seed 1): crashed: last words",
    ]


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress_on_terminal_shows_time_left_and_scores() -> None:
    """On a terminal, the display shows the time left and the current scores."""
    times = iter((0.0, 60.0, 60.0, 60.0))
    out = Terminal()
    board = ProgressDisplay(total=11, before=0, out=out, now=lambda: next(times))
    board.is_over(task(1), outcome_of(task(1)), None)
    shown = out.getvalue()
    assert "1/11  time left: 10 min" in shown
    assert "Overtaking" in shown


def test_sweep_has_each_combination_in_own_folder() -> None:
    """A sweep has every combination of its settings, each in a folder of its own."""
    spec = EvaluationSpec("dev", Path("out"), SystemSpec(recovery="search"))
    specs = sweep_specs(spec, parse_sweep(["v_min=3.6,18", "dt=0.5,1"]))
    assert list(specs) == ["v_min=3.6,dt=0.5", "v_min=3.6,dt=1", "v_min=18,dt=0.5", "v_min=18,dt=1"]
    last = specs["v_min=18,dt=1"]
    assert last.out == Path("out/v_min=18,dt=1")
    assert last.arm.detector == pytest.approx({"v_min_mps": 5.0, "dwell_s": 1.0})


@pytest.mark.parametrize("text", ["speed=1", "v_min=fast", "dt=0", "dt=-1", "v_min="])
def test_a_bad_sweep_is_named(text: str) -> None:
    with pytest.raises(SweepError, match=text):
        parse_sweep([text])


def test_weather_changes_evenly_between_its_keys() -> None:
    keys = [WeatherKey(20.0, {"cloudiness": 10.0}), WeatherKey(60.0, {"cloudiness": 50.0})]
    assert [between(keys, p)["cloudiness"] for p in (0.0, 20.0, 30.0, 60.0, 100.0)] == [10.0, 10.0, 20.0, 50.0, 50.0]


def test_immobilization_spell_lasts_until_15_m_of_progress() -> None:
    """A spell lasts from its onset to 15 m of progress."""
    watch = ImmobilizationWatch()
    place, time_s = 0.0, 0.0
    for speed, seconds in ((10.0, 5.0), (0.0, 20.0), (5.0, 10.0), (0.0, 8.0)):
        for _ in range(round(seconds / 0.05)):
            watch.update(time_s, speed, place)
            time_s, place = time_s + 0.05, place + 0.05 * speed
    watch.finish(time_s)
    first, second = watch.spells
    assert first.onset_s == pytest.approx(5.0, abs=0.06)
    assert first.recovered_after_s == pytest.approx(23.0, abs=0.1)
    assert (second.recovered_after_s, second.ended_s) == (None, pytest.approx(43.0))
