"""Bodies of a route's process that go wrong; in a module of their own, so that a spawned process finds them."""

from __future__ import annotations

import os
import signal
from multiprocessing.connection import Connection

from stucksolver_eval.runner import work
from stucksolver_eval.runner.work import Task

_real = work._work


def crash_on_one(task: Task, theirs: Connection) -> None:
    """Dies on route 1 as a crash of the client library does; the others are driven."""
    if task.job.route.id == "1":
        os.kill(os.getpid(), signal.SIGSEGV)
    _real(task, theirs)


def raise_something(task: Task, theirs: Connection) -> None:
    raise RuntimeError("a defect")
