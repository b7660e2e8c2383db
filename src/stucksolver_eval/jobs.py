"""One run, one process, one server: a crash of the client library or the simulator costs that run alone."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Literal

from stucksolver_eval.files import OutputError, write_text
from stucksolver_eval.runlog import RunLog
from stucksolver_eval.server import Server, ServerError, carlette_server, remote_server
from stucksolver_eval.situation import Scenario, SituationError

CLIENT_TIMEOUT_S = 15.0
PROGRESS_EVERY_S = 5.0
SILENCE_S = 180.0
"""A run that tells of no progress for this long hangs."""
LOOK_S = 0.5
"""How often to ask whether a run is wanted still."""
LEAVE_S = 10.0
"""For a run's process to leave by itself."""
TRIES = 2
"""A run whose process was killed by a signal (the client library can crash) is made once more."""


class RunError(RuntimeError):
    """A run could not be made; the message says why and what to do."""


class NotWanted(Exception):
    """The program is being ended, and its runs' processes with it: that is no crash of a run."""


@dataclass(frozen=True)
class Job:
    """Everything that one run needs, so that it can be made in another process.

    `host`, `port`: a running CARLA server instead of a carlette of our own. `log`: where its log is written.
    """

    scenario: Scenario
    arm: str
    with_solver: bool
    guidance: tuple[tuple[float, str], ...]
    map_name: str
    maps: str | None
    road: Literal["one_lane", "multi_lane", "any"]
    oncoming: int
    seed: int
    profile: str
    clock: str
    log: Path
    host: str | None = None
    port: int = 2000


def make(job: Job, progress: Callable[[float], None]) -> tuple[RunLog, int]:
    """Make a run in a process of its own; gives its log and how often it had to be repeated. Raises `RunError`."""
    for attempt in range(TRIES):
        code = _attempt(job, progress)
        if code == 0:
            return RunLog.model_validate_json(job.log.read_text(encoding="utf-8")), attempt
        if code > 0:
            raise RunError(f"the run ended with exit code {code}; what happened is printed above")
    raise RunError(f"the run's process was killed by {signal.Signals(-code).name}, {TRIES} times in a row")


def _attempt(job: Job, progress: Callable[[float], None]) -> int:
    return attempt(_work, job, progress)


def attempt(
    work: Callable[[Any, Connection], None],
    job: Any,
    progress: Callable[[float], None],
    wanted: Callable[[], bool] = lambda: True,
) -> int:
    """Do `work` on a job in a process of its own; the exit code, negative: the signal that killed it.

    Numbers that the process sends are progress; a text is what went wrong. Raises `RunError` with that text, or when
    nothing is heard for too long, and `NotWanted`; whatever is raised, the process is over by then.
    """
    if not wanted():
        raise NotWanted
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=work, args=(job, theirs), daemon=True)
    # Ctrl-C reaches every process of a terminal; the run's shall not know it, not even while it starts.
    # (Starting Python's own helper would undo the block.)
    resource_tracker.ensure_running()
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    theirs.close()
    try:
        _listen(ours, progress, wanted)
        process.join(LEAVE_S)
    finally:
        _end(process)
        ours.close()
    return int(process.exitcode or 0)


def _end(process: BaseProcess) -> None:
    """End a process that is still there; one that waits inside the client library hears nothing but a kill."""
    if process.is_alive():
        process.terminate()
        process.join(LEAVE_S)
    if process.is_alive():
        process.kill()
        process.join()


def _listen(ours: Connection, progress: Callable[[float], None], wanted: Callable[[], bool]) -> None:
    """Take progress until the run is over. Raises `RunError` with what it says went wrong, and `NotWanted`."""
    heard = time.monotonic()
    while True:
        if not wanted():
            raise NotWanted
        if not ours.poll(LOOK_S):
            if time.monotonic() - heard > SILENCE_S:
                raise RunError(f"the run has not gone on for {SILENCE_S:.0f} s and was ended; run again")
            continue
        heard = time.monotonic()
        try:
            message: Any = ours.recv()
        except EOFError:
            return
        if isinstance(message, str):
            raise RunError(message)
        progress(float(message))


def _work(job: Job, theirs: Connection) -> None:
    """The body of the run's process."""
    # Ctrl-C is the parent's business: it ends us. Its death is noticed by the pipe.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _leave)
    from stucksolver.stacks.driver import RouteError
    from stucksolver_eval.run import run_job
    from stucksolver_eval.sites import SiteError

    try:
        with _server(job) as server, watched(server, theirs):
            try:
                log = run_job(job, server, theirs.send)
            except RuntimeError as error:
                if isinstance(error, SituationError):
                    raise
                server.check()
                raise ServerError(f"the simulator at {server.host}:{server.port} does not answer: {error}") from error
        write_text(job.log, log.model_dump_json())
    except BrokenPipeError:
        raise SystemExit(1) from None
    except (ServerError, SiteError, SituationError, RouteError, OutputError) as error:
        # Nothing is left to unwind, and we may be ended as soon as we have spoken.
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        theirs.send(str(error))


@contextlib.contextmanager
def watched(server: Server, theirs: Connection) -> Iterator[None]:
    """Tell of a simulator's death at once: the client library would wait for it, call by call."""
    over = threading.Event()

    def watch() -> None:
        if server.process is None:
            return
        server.process.wait()
        if over.is_set():
            return
        with contextlib.suppress(OSError):
            theirs.send(f"the simulator ended with exit code {server.process.returncode}; run again")
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        over.set()


def _leave(number: int, frame: object) -> None:
    """On SIGTERM: unwind, so that the server is ended too."""
    raise SystemExit(1)


def _server(job: Job) -> contextlib.AbstractContextManager[Server]:
    if job.host is not None:
        return contextlib.nullcontext(remote_server(job.host, job.port))
    return carlette_server(job.map_name, job.maps, job.seed)
