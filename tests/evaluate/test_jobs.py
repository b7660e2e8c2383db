"""A run is made in a process of its own: whatever happens there, there is a log or one clear error, and no orphan."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

pytest.importorskip("carla")

import crashers

from stucksolver_eval import jobs
from stucksolver_eval.jobs import Job, RunError, make
from stucksolver_eval.situation import Scenario

pytestmark = pytest.mark.integration


@pytest.fixture(autouse=True)
def no_orphan() -> Iterator[None]:
    """Every process that a run started is gone when it is over."""
    before = {one.pid for one in psutil.Process().children(recursive=True)}
    yield
    deadline = time.monotonic() + 5.0
    while left := [one for one in psutil.Process().children(recursive=True) if one.pid not in before and not _own(one)]:
        assert time.monotonic() < deadline, left
        time.sleep(0.05)


def _own(process: psutil.Process) -> bool:
    """Python's own helper, which lives as long as we do."""
    try:
        return "resource_tracker" in " ".join(process.cmdline())
    except psutil.NoSuchProcess:
        return True


@pytest.fixture
def job(tmp_path: Path) -> Job:
    return Job(
        scenario=Scenario.PARKED_CAR,
        arm="driver alone",
        with_solver=False,
        guidance=(),
        map_name="demo_town",
        maps=None,
        road="any",
        oncoming=0,
        seed=1,
        profile="normal",
        clock="lockstep",
        log=tmp_path / "log.json",
    )


def changed(job: Job, **changes: object) -> Job:
    return Job(**(vars(job) | changes))


def silent(_: float) -> None:
    """Progress that nobody wants to hear of."""


def test_a_crash_is_tried_once_more_and_then_named(job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "_work", crashers.always_crash)
    with pytest.raises(RunError, match="killed by SIGSEGV, 2 times in a row"):
        make(job, silent)
    assert job.log.with_suffix(".attempts").read_text() == "xx"
    assert not job.log.exists()


def test_a_run_that_crashed_once_is_repeated_and_says_so(job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "_work", crashers.crash_once)
    log, repeated = make(changed(job, with_solver=True), silent)
    assert repeated == 1
    assert log.result.status == "completed"
    assert job.log.exists()


def test_another_end_is_not_tried_again(job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "_work", crashers.leave_with_3)
    with pytest.raises(RunError, match="exit code 3"):
        make(job, silent)
    assert job.log.with_suffix(".attempts").read_text() == "x"


def test_a_process_that_hears_no_signal_is_ended_all_the_same(job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "_work", crashers.complain_and_stay)
    monkeypatch.setattr(jobs, "LEAVE_S", 0.5)
    with pytest.raises(RunError, match="something is wrong"):
        make(job, silent)


def test_a_run_that_hangs_is_ended(job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "_work", crashers.hang)
    monkeypatch.setattr(jobs, "SILENCE_S", 4.0)
    with pytest.raises(RunError, match="has not gone on for 4 s"):
        make(job, silent)


def test_what_is_wrong_in_there_is_told_here(job: Job) -> None:
    with pytest.raises(RunError, match="'Nowhere'"):
        make(changed(job, map_name="Nowhere"), silent)


def test_a_site_that_the_map_does_not_have_is_told(job: Job, tmp_path: Path) -> None:
    folder = tmp_path / "file"
    folder.write_text("not a folder")
    with pytest.raises(RunError, match=r"cannot write .*file"):
        make(changed(job, with_solver=True, log=folder / "log.json"), silent)


class KillServer:
    """Kills the run's simulator when the run has got to a time."""

    def __init__(self, at_s: float) -> None:
        self.at_s = at_s
        self.others = set(psutil.Process().children(recursive=True))
        self.killed_at: float | None = None

    def __call__(self, elapsed_s: float) -> None:
        if self.killed_at is None and elapsed_s >= self.at_s:
            ours = set(psutil.Process().children(recursive=True)) - self.others
            found = [one for one in ours if "carlette" in one.cmdline()]
            assert len(found) == 1
            os.kill(found[0].pid, signal.SIGKILL)
            self.killed_at = time.monotonic()


def test_a_server_that_dies_during_a_run_is_one_clear_error_soon(job: Job) -> None:
    kill = KillServer(at_s=5.0)
    with pytest.raises(RunError) as told:
        make(job, kill)
    assert kill.killed_at is not None and time.monotonic() - kill.killed_at < 20.0
    assert str(told.value) == "the simulator ended with exit code -9; run again"
    assert not job.log.exists()


def test_a_server_that_dies_under_a_traffic_manager_is_told_or_the_run_made_again(job: Job) -> None:
    kill = KillServer(at_s=5.0)
    began = time.monotonic()
    try:
        log, repeated = make(changed(job, with_solver=True, oncoming=2, road="one_lane"), kill)
    except RunError as error:
        assert "simulator ended with exit code -9" in str(error)
    else:
        # The client library gave up on its own process: then the run is made once more.
        assert (repeated, log.result.status) == (1, "completed")
    assert time.monotonic() - began < 45.0
