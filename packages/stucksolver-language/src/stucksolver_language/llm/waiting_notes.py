"""Says on standard error what is waited for, so that a slow server is not taken for a command that hangs."""

from __future__ import annotations

import sys
import threading
import time
from types import TracebackType

FIRST_NOTE_S = 10.0
"""Time until the first line (s). Each further line takes twice as long. Ours."""


class WaitingNotes:
    """Context in which a line is printed after 10, 20, 40 … seconds, with what is waited for.

    Args:
        name: Name of the model.
        limit_s: Time after which the wait ends (s).
    """

    def __init__(self, name: str, limit_s: float) -> None:
        self._name, self._limit_s = name, limit_s
        self._what, self._began = "", time.monotonic()
        self._ended = threading.Event()

    def begin(self, what: str) -> None:
        """State what is waited for from now on."""
        self._what = what

    def __enter__(self) -> WaitingNotes:
        self._began = time.monotonic()
        threading.Thread(target=self._print, name="stucksolver-waiting", daemon=True).start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()

    def _print(self) -> None:
        after_s = FIRST_NOTE_S
        while not self._ended.wait(max(self._began + after_s - time.monotonic(), 0.0)):
            print(
                f"note: {self._name}: waiting for the answer to {self._what}, {after_s:g} of at most {self._limit_s:g} "
                "s (a server may be loading its model)",
                file=sys.stderr,
                flush=True,
            )
            after_s *= 2
