"""Runs work in a separate process, so that a crash of the client library or the simulator affects only that work."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Iterator
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from stucksolver.interrupts import uninterrupted
from stucksolver_carla.client_connection import SimulatorServer

PROGRESS_EVERY_S = 5.0
SILENCE_S = 180.0
"""A run that reports no progress for this long counts as hanging."""
LOOK_S = 0.5
"""Interval at which to check whether a run is still wanted."""
LEAVE_S = 10.0
"""Time for a run's process to exit by itself."""

_PRELOADED = ("stucksolver_eval.runner.drive", "stucksolver_eval.runner.route_process", "stucksolver_eval.drivers")


class RunError(RuntimeError):
    """A run failed; the message says why and what to do."""


class RunCancelledError(Exception):
    """The program is ending, and its processes with it; this is not a crash of a run."""


def attempt(
    work: Callable[[Any, Connection], None],
    job: Any,
    progress: Callable[[float], None],
    wanted: Callable[[], bool] = lambda: True,
) -> int:
    """Run `work` on a job in a separate process. Returns its exit code; negative if a signal killed it.

    Numbers that the process sends are progress; a text is an error. Raises `RunError` with that text or after
    `SILENCE_S` without progress, and `RunCancelledError`. In all cases the process has ended by then.
    """
    if not wanted():
        raise RunCancelledError
    # Forked from a helper that has imported what a drive needs, which takes a second, and does nothing else.
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(_PRELOADED))
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_work_here, args=(work, job, theirs, dict(os.environ)), daemon=True)
    # Ctrl-C reaches every process of a terminal; the run's process must not get it, not even while it starts.
    # (Start Python's own helper first, because starting it would undo the block.)
    resource_tracker.ensure_running()
    try:
        with uninterrupted():
            process.start()
        theirs.close()
        _listen(ours, progress, wanted)
        process.join(LEAVE_S)
    finally:
        _end(process)
        ours.close()
    return int(process.exitcode or 0)


def _work_here(work: Callable[[Any, Connection], None], job: Any, theirs: Connection, environ: dict[str, str]) -> None:
    """Do the work in the environment that the program has now; the helper has that of its own start."""
    os.environ.clear()
    os.environ.update(environ)
    work(job, theirs)


def _end(process: BaseProcess) -> None:
    """End a process that is still running; one that waits inside the client library reacts only to a kill."""
    if process.is_alive():
        process.terminate()
        process.join(LEAVE_S)
    if process.is_alive():
        process.kill()
        process.join()


def _listen(ours: Connection, progress: Callable[[float], None], wanted: Callable[[], bool]) -> None:
    """Receive progress until the run is over. Raises `RunError` with the error it reports, and `RunCancelledError`."""
    heard = time.monotonic()
    while True:
        if not wanted():
            raise RunCancelledError
        if not ours.poll(LOOK_S):
            if time.monotonic() - heard > SILENCE_S:
                raise RunError(f"the run made no progress for {SILENCE_S:.0f} s and was ended; run again")
            continue
        heard = time.monotonic()
        try:
            message: Any = ours.recv()
        except EOFError:
            return
        if isinstance(message, str):
            raise RunError(message)
        progress(float(message))


@contextlib.contextmanager
def watched(server: SimulatorServer, theirs: Connection) -> Iterator[None]:
    """Report the simulator's death immediately; the client library would wait for a timeout on each call."""
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
