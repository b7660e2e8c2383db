"""Delays Ctrl-C during work that must not end halfway."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Delay Ctrl-C in the body until its end; a process that is started in the body never receives it.

    Without this, a Ctrl-C could come between the start of a Python process and the message with its job. The process
    would then die with a traceback.
    """
    pending: list[int] = []

    def hold(number: int, _frame: FrameType | None) -> None:
        pending.append(number)

    # The mask is for the processes started here, which inherit it. It does not protect this process: the system
    # delivers the signal to any thread that accepts it, and Python then interrupts the main thread.
    main = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGINT, hold) if main else None
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        if main:
            signal.signal(signal.SIGINT, before)
    if pending:
        signal.raise_signal(signal.SIGINT)
