"""A route is driven in a process of its own: whatever happens there, there is one clear reason, and no orphan."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

pytest.importorskip("carla")

import route_crashers

from stucksolver_eval.routes import Position, Route
from stucksolver_eval.runner import isolated_process as process
from stucksolver_eval.runner import route_process
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.route_process import RouteTask, run_task
from stucksolver_eval.systems.spec import SystemSpec

pytestmark = pytest.mark.integration
STREET = (Position(128.0, 1.75, 0.0), Position(297.0, 1.75, 0.0))


@pytest.fixture(autouse=True)
def no_orphan() -> Iterator[None]:
    """Every process that a run started is gone when it is over."""
    before = {child.pid for child in psutil.Process().children(recursive=True)}
    yield
    deadline = time.monotonic() + 60.0
    while left := [
        child for child in psutil.Process().children(recursive=True) if child.pid not in before and not _own(child)
    ]:
        assert time.monotonic() < deadline, left
        time.sleep(0.05)


def _own(process: psutil.Process) -> bool:
    """Python's own helpers, which live as long as we do."""
    try:
        command = " ".join(process.cmdline())
        return "resource_tracker" in command or ("forkserver" in command and process.ppid() == os.getpid())
    except psutil.NoSuchProcess:
        return True


def task(folder: Path, limit_s: float | None = None) -> RouteTask:
    route = Route("7", "demo_town", STREET)
    return RouteTask(RouteJob(route=route, seed=1, arm=SystemSpec(), background=False, limit_s=limit_s), folder)


def reason(folder: Path) -> str:
    outcome = run_task(task(folder))
    assert outcome.state == "crashed"
    return outcome.reason


def test_a_crash_is_tried_once_more_and_then_named(tmp_path, monkeypatch):
    monkeypatch.setattr(route_process, "_work", route_crashers.always_crash)
    assert "killed by SIGSEGV, 2 times in a row" in reason(tmp_path)
    assert (tmp_path / "attempts").read_text(encoding="utf-8") == "xx"


def test_a_route_that_crashed_once_is_driven_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(route_process, "_work", route_crashers.crash_once)
    assert run_task(task(tmp_path, limit_s=2.0)).state == "driven"
    assert (tmp_path / "attempts").read_text(encoding="utf-8") == "xx"


def test_another_end_is_not_tried_again(tmp_path, monkeypatch):
    monkeypatch.setattr(route_process, "_work", route_crashers.leave_with_3)
    assert "exit code 3" in reason(tmp_path)
    assert (tmp_path / "attempts").read_text(encoding="utf-8") == "x"


def test_route_process_ignoring_signals_is_killed(tmp_path, monkeypatch):
    """A process that ignores signals is killed all the same."""
    monkeypatch.setattr(route_process, "_work", route_crashers.complain_and_stay)
    monkeypatch.setattr(process, "LEAVE_S", 0.5)
    assert reason(tmp_path) == "something is wrong"


def test_a_route_that_hangs_is_ended(tmp_path, monkeypatch):
    monkeypatch.setattr(route_process, "_work", route_crashers.hang)
    monkeypatch.setattr(process, "SILENCE_S", 1.0)
    assert "made no progress for 1 s" in reason(tmp_path)


def test_route_process_killed_server_gives_prompt_clear_reason(tmp_path):
    """A server that dies during a route gives one clear reason before the time limit for silence."""
    others = set(psutil.Process().children(recursive=True))
    killed_at: list[float] = []

    def kill(elapsed_s: float) -> None:
        if not killed_at and elapsed_s >= 5.0:
            ours = set(psutil.Process().children(recursive=True)) - others
            (simulator,) = [our for our in ours if "carlette" in our.cmdline()]
            os.kill(simulator.pid, signal.SIGKILL)
            killed_at.append(time.monotonic())

    outcome = run_task(task(tmp_path), kill)
    assert killed_at and time.monotonic() - killed_at[0] < process.SILENCE_S
    assert (outcome.state, outcome.reason) == ("crashed", "the simulator ended with exit code -9; run again")
