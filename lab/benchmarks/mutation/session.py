"""Collects the tests once, and runs parts of them in forks of that process."""

from __future__ import annotations

import json
import os
import resource
import select
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import pytest

GENERAL = ("test_guard_kept", "test_guard_oracle", "test_guard_closed_loop", "test_guard_proofs", "test_guard_symmetry")
"""Stored verdicts and random worlds. They run last.

They detect a change, but do not name the broken promise.
"""
FEWER = {"GUARD_EXAMPLES": "10", "GUARD_SCENES": "16", "MACHINE_DRIVES": "0"}
"""Numbers of random worlds that the tests draw. They are small, because thousands of mutants run. Ours."""
PYTEST = (
    "-q",
    "-p",
    "no:cacheprovider",
    "-p",
    "no:xdist",
    "--tb=line",
    "--assert=plain",
    "-o",
    "faulthandler_timeout=0",
    "--continue-on-collection-errors",
    "-m",
    "not slow",
)
SLACK_S, SLOWER = 20.0, 20.0
"""A run counts as endless beyond this CPU time (s) and this multiple of the time without a change. Ours."""
WALL = 10.0
"""The same for the wall time, which other processes share, as a multiple of the limit of CPU time. Ours."""


def prepare() -> None:
    """Make every run of a test alike: the same examples, none remembered, one thread."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"
    os.environ.update(FEWER)
    from hypothesis import HealthCheck, Phase, settings

    # Register this first: profiles that the tests register later inherit from it.
    settings.register_profile(
        "mutation",
        derandomize=True,
        database=None,
        deadline=None,
        phases=(Phase.explicit, Phase.generate),
        suppress_health_check=list(HealthCheck),
    )
    settings.load_profile("mutation")


class Session:
    """The plugin: it passes the collected tests to `serve` instead of running them."""

    def __init__(self, serve: Callable[[list[pytest.Item]], None]) -> None:
        self._serve = serve
        self.failed = False
        self.skipped = False

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Replace pytest's own loop, without its dots."""
        session.config.pluginmanager.unregister(name="terminalreporter")
        self._serve(list(session.items))
        return True

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note the outcome of the test in progress."""
        self.failed |= report.failed
        self.skipped |= report.skipped

    def run(self, item: pytest.Item, after: pytest.Item | None) -> tuple[str, float]:
        """Run one test; return `passed`, `failed` or `skipped`, and the CPU time (s)."""
        self.failed = self.skipped = False
        began = time.process_time()
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=after)
        took = time.process_time() - began
        return ("failed" if self.failed else "skipped" if self.skipped else "passed"), took


def collect(paths: Sequence[str], session: Session) -> None:
    """Collect the tests at these paths and pass them to the session. A file that cannot be imported is left out."""
    pytest.main([*PYTEST, *paths], plugins=[session])


@dataclass(frozen=True)
class Job:
    """Work of a fork: `work` yields messages for the parent; `cpu_s` is its limit of CPU time."""

    key: Any
    work: Callable[[], Iterable[Any]]
    cpu_s: float


@dataclass
class _Child:
    job: Job
    pid: int
    pipe: int
    folder: str
    until_s: float
    told: bytes = b""


@dataclass(frozen=True)
class Ended:
    """The end of a job.

    Attributes:
        key: The job's.
        told: The messages of its work.
        how: `done`, `time` (over its limit) or `died`.
        took_s: CPU time (s).
    """

    key: Any
    told: list[Any]
    how: str
    took_s: float


def in_forks(jobs: Iterable[Job], processes: int) -> Iterator[Ended]:
    """Run jobs in forks, at most `processes` at a time, and yield the end of each."""
    waiting, running = iter(jobs), dict[int, _Child]()
    more = True
    while more or running:
        while more and len(running) < processes:
            job = next(waiting, None)
            if job is None:
                more = False
                break
            child = _fork(job)
            running[child.pipe] = child
        if not running:
            continue
        ready, _, _ = select.select(list(running), [], [], 1.0)
        for pipe in ready:
            child = running[pipe]
            part = os.read(pipe, 1 << 16)
            if part:
                child.told += part
                continue
            del running[pipe]
            yield _ended(child)
        for child in running.values():
            if time.monotonic() > child.until_s:
                _kill(child.pid)


def _fork(job: Job) -> _Child:
    reading, writing = os.pipe()
    folder = tempfile.mkdtemp(prefix="mutant-")
    pid = os.fork()
    if pid:
        os.close(writing)
        return _Child(job, pid, reading, folder, time.monotonic() + WALL * job.cpu_s)
    code = 1
    try:
        os.setpgid(0, 0)
        os.close(reading)
        os.environ["PYTEST_DEBUG_TEMPROOT"] = os.environ["TMPDIR"] = tempfile.tempdir = folder
        nothing = os.open(os.devnull, os.O_RDWR)
        for standard in (0, 1, 2):
            os.dup2(nothing, standard)
        used = resource.getrusage(resource.RUSAGE_SELF)
        most = int(used.ru_utime + used.ru_stime + job.cpu_s) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1))
        for message in job.work():
            os.write(writing, json.dumps(message).encode() + b"\n")
        code = 0
    finally:
        os._exit(code)


def _kill(group: int) -> None:
    try:
        os.killpg(group, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        # The group has already ended, or the system has reaped it.
        return


def _ended(child: _Child) -> Ended:
    os.close(child.pipe)
    _, status, used = os.wait4(child.pid, 0)
    # End the processes that a test has started and not ended.
    _kill(child.pid)
    shutil.rmtree(child.folder, ignore_errors=True)
    messages = [json.loads(line) for line in child.told.splitlines() if line.endswith(b"]")]
    if os.WIFSIGNALED(status):
        how = "time" if os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL) else "died"
    else:
        how = "done" if status == 0 else "died"
    return Ended(child.job.key, messages, how, used.ru_utime + used.ru_stime)


def short(item: pytest.Item) -> str:
    """Return a test's name with its file, without the folders."""
    file, name = item.nodeid.split("::", 1)
    return f"{file.rsplit('/', 1)[-1]}::{name}"


def is_general(name: str) -> bool:
    """True for tests that detect a change without naming the broken promise."""
    return name.split(".py", 1)[0] in GENERAL


def say(text: str) -> None:
    """Report progress."""
    print(text, file=sys.stderr, flush=True)
