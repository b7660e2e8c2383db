"""Bodies of a route's process that go wrong; in a module of their own, so that a spawned process finds them."""

from __future__ import annotations

import os
import signal
import time
from multiprocessing.connection import Connection

from stucksolver_eval.runner import route_process
from stucksolver_eval.runner.route_process import RouteTask

_real = route_process._work


def crash_on_one(task: RouteTask, theirs: Connection) -> None:
    """Dies on route 1 as a crash of the client library does; the others are driven."""
    if task.job.route.id == "1":
        os.kill(os.getpid(), signal.SIGSEGV)
    _real(task, theirs)


def raise_something(task: RouteTask, theirs: Connection) -> None:
    raise RuntimeError("a defect")


def attempts(task: RouteTask) -> int:
    """Notes that there was an attempt; how many there were."""
    notes = task.folder / "attempts"
    notes.write_text(notes.read_text(encoding="utf-8") + "x" if notes.exists() else "x", encoding="utf-8")
    return len(notes.read_text(encoding="utf-8"))


def always_crash(task: RouteTask, theirs: Connection) -> None:
    attempts(task)
    os.kill(os.getpid(), signal.SIGSEGV)


def crash_once(task: RouteTask, theirs: Connection) -> None:
    """The second attempt is a real drive."""
    if attempts(task) == 1:
        theirs.send(0.0)
        os.kill(os.getpid(), signal.SIGSEGV)
    _real(task, theirs)


def leave_with_3(task: RouteTask, theirs: Connection) -> None:
    attempts(task)
    raise SystemExit(3)


def complain_and_stay(task: RouteTask, theirs: Connection) -> None:
    """Tells what is wrong, then hears no signal, like a wait inside the client library."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    theirs.send("something is wrong")
    time.sleep(600)


def hang(task: RouteTask, theirs: Connection) -> None:
    theirs.send(0.0)
    time.sleep(600)
