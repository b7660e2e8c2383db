"""An event loop in its own thread. It gives an exchange a hard time limit and lets any thread cancel it."""

from __future__ import annotations

import asyncio
import concurrent.futures
import threading
from collections.abc import Coroutine
from typing import Any, TypeVar

T = TypeVar("T")


class Cancelled(Exception):
    """The answer is no longer needed."""


class DeadlineError(Exception):
    """The answer was later than its limit."""


class Loop:
    """Runs one coroutine at a time. Its thread is a daemon, so it does not keep the process alive."""

    def __init__(self) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._running: concurrent.futures.Future[Any] | None = None
        self._lock = threading.Lock()

    def run(self, work: Coroutine[Any, Any, T], limit_s: float) -> T:
        """Run `work` for at most `limit_s` (s) and return its result.

        Raises:
            DeadlineError: It took longer than `limit_s` (s).
            Canceled: `cancel` was called.
            Exception: Whatever `work` raises.
        """
        with self._lock:
            if self._loop is None:
                self._loop = asyncio.new_event_loop()
                threading.Thread(target=self._loop.run_forever, name="stucksolver-model", daemon=True).start()
            running = self._running = asyncio.run_coroutine_threadsafe(work, self._loop)
        try:
            result: T = running.result(timeout=max(limit_s, 0.0))
            return result
        except concurrent.futures.CancelledError:
            raise Cancelled from None
        except concurrent.futures.TimeoutError:
            if running.done() and not running.cancelled() and (error := running.exception()) is not None:
                raise error from None
            running.cancel()
            raise DeadlineError from None
        finally:
            with self._lock:
                self._running = None

    def cancel(self) -> None:
        """Cancel the running coroutine, if any."""
        with self._lock:
            if self._running is not None:
                self._running.cancel()
