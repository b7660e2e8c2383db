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
"""Interval between two progress messages of a run (s). Ours."""
SILENCE_S = 180.0
"""Time without progress after which a run counts as hanging (s). Ours."""
LOOK_S = 0.5
"""Interval between two checks whether a run is still needed (s). Ours."""
LEAVE_S = 10.0
"""Time for a run's process to exit on its own (s). Ours."""

_PRELOADED = ("stucksolver_eval.runner.drive", "stucksolver_eval.runner.route_process", "stucksolver_eval.drivers")


class RunError(RuntimeError):
    """A run failed. The message states the reason and the remedy."""


class RunCancelledError(Exception):
    """The program ends together with its processes. This is not a crash of a run."""


def attempt(
    work: Callable[[Any, Connection], None],
    job: Any,
    progress: Callable[[float], None],
    wanted: Callable[[], bool] = lambda: True,
) -> int:
    """Run `work` on a job in a separate process. Returns its exit code; negative if a signal killed it.

    Numbers from the process are progress; a text is an error. Raises `RunError` with that text or after `SILENCE_S`
    without progress, and `RunCancelledError`. In all cases the process has ended on return.
    """
    if not wanted():
        raise RunCancelledError
    # The fork server has imported the modules of a drive, which takes a second, and does nothing else.
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(_PRELOADED))
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_work_here, args=(work, job, theirs, dict(os.environ)), daemon=True)
    # Ctrl-C reaches every process of a terminal. The run's process must not get it, not even during its start. Python's
    # resource tracker starts first, because its start would remove the block of the signal.
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
    """Run the work in the program's present environment. The fork server has that of its own start."""
    os.environ.clear()
    os.environ.update(environ)
    work(job, theirs)


def _end(process: BaseProcess) -> None:
    """End a running process. A process that waits inside the client library reacts only to a kill."""
    if process.is_alive():
        process.terminate()
        process.join(LEAVE_S)
    if process.is_alive():
        process.kill()
        process.join()


def _listen(ours: Connection, progress: Callable[[float], None], wanted: Callable[[], bool]) -> None:
    """Receive progress until the run is over.

    Raises `RunError` with an error of the process, and `RunCancelledError`.
    """
    last_message = time.monotonic()
    while True:
        if not wanted():
            raise RunCancelledError
        if not ours.poll(LOOK_S):
            if time.monotonic() - last_message > SILENCE_S:
                raise RunError(f"the run made no progress for {SILENCE_S:.0f} s and was ended; run again")
            continue
        last_message = time.monotonic()
        try:
            message: Any = ours.recv()
        except EOFError:
            # The process has closed the pipe, so the run is over; its exit code shows whether it succeeded.
            return
        if isinstance(message, str):
            raise RunError(message)
        progress(float(message))


@contextlib.contextmanager
def watched(server: SimulatorServer, theirs: Connection) -> Iterator[None]:
    """Report the end of the simulator immediately. The client library would wait for a timeout on each call."""
    over = threading.Event()

    def watch() -> None:
        if server.process is None:
            return
        server.process.wait()
        if over.is_set():
            return
        # The parent may have ended too.
        with contextlib.suppress(OSError):
            theirs.send(f"the simulator ended with exit code {server.process.returncode}; run again")
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        over.set()
