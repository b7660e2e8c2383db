"""Bodies of a run's process that go wrong; in a module of their own, so that a spawned process finds them."""

from __future__ import annotations

import os
import signal
import time
from multiprocessing.connection import Connection

from stucksolver_eval.jobs import Job, _work


def attempts(job: Job) -> int:
    """Notes that there was an attempt; how many there were."""
    notes = job.log.with_suffix(".attempts")
    notes.write_text(notes.read_text() + "x" if notes.exists() else "x")
    return len(notes.read_text())


def always_crash(job: Job, theirs: Connection) -> None:
    """Dies as a crash of the client library does."""
    attempts(job)
    os.kill(os.getpid(), signal.SIGSEGV)


def crash_once(job: Job, theirs: Connection) -> None:
    """The second attempt is a real run."""
    if attempts(job) == 1:
        theirs.send(0.0)
        os.kill(os.getpid(), signal.SIGSEGV)
    _work(job, theirs)


def leave_with_3(job: Job, theirs: Connection) -> None:
    attempts(job)
    raise SystemExit(3)


def complain_and_stay(job: Job, theirs: Connection) -> None:
    """Tells what is wrong, then hears no signal, like a wait inside the client library."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    theirs.send("something is wrong")
    time.sleep(600)


def hang(job: Job, theirs: Connection) -> None:
    theirs.send(0.0)
    time.sleep(600)
