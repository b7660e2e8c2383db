"""Decides when an answer is delivered. The clock is injected, so a run can be repeated or charged for latency."""

from __future__ import annotations

import math
import time
from concurrent.futures import Future, TimeoutError
from dataclasses import dataclass
from typing import Protocol, TypeVar

T = TypeVar("T")
WAIT_LIMIT_S = 60.0
"""Longest wall time for which a simulated world waits, unless a reasoner's deadline is longer (s). After that, the
answer counts as missing. Ours.
"""


@dataclass
class Pending:
    """Running query to a reasoner or to the interpreter."""

    asked_s: float
    asked_wall_s: float
    ticks: int = 0
    """Number of calls of `step` since the query."""
    wait_s: float = WAIT_LIMIT_S
    """Longest time for which a simulated world waits for the answer (s)."""
    took_s: float | None = None
    """Wall time until the answer (s); None before the answer."""


class DeliveryClock(Protocol):
    """Decision at each tick whether an answer may be delivered, with a wait for it if time is only simulated."""

    name: str

    def due(self, query: Pending, now_s: float, answer: Future[T]) -> bool:
        """True if the answer should be used now. It is ready, unless the reasoner hangs."""


class Lockstep:
    """Delivery on the next tick, regardless of the wall time, as the CARLA leaderboard does."""

    name = "lockstep"

    def due(self, query: Pending, now_s: float, answer: Future[T]) -> bool:
        """Return True after waiting for the answer while the simulated world is stopped."""
        _wait(answer, query.wait_s)
        return True


class FixedLatency:
    """Delivery after a fixed time in a world that continues."""

    def __init__(self, latency_s: float) -> None:
        if not 0 <= latency_s < math.inf:
            raise ValueError(f"latency must be finite and at least 0 s, not {latency_s}")
        self.latency_s = latency_s
        self.name = f"latency:{latency_s:g}"

    def due(self, query: Pending, now_s: float, answer: Future[T]) -> bool:
        """True after the latency has passed in the world's time."""
        if now_s - query.asked_s < self.latency_s - 1e-6:
            return False
        _wait(answer, query.wait_s)
        return True


class MeasuredLatency:
    """Delivery after as many ticks as the answer took in wall time; not repeatable."""

    name = "latency:measured"

    def due(self, query: Pending, now_s: float, answer: Future[T]) -> bool:
        """True after as much time has passed in the world as the answer took."""
        simulated = now_s - query.asked_s
        if not answer.done():
            _wait(answer, max(query.asked_wall_s + simulated - time.monotonic(), 0.0))
        if not answer.done():
            return False
        took = query.took_s if query.took_s is not None else time.monotonic() - query.asked_wall_s
        per_tick = simulated / max(query.ticks, 1)
        return per_tick <= 0 or query.ticks >= math.ceil(took / per_tick)


class WallClock:
    """Delivery as soon as the answer is ready, without waiting. For live stacks."""

    name = "wall"

    def due(self, query: Pending, now_s: float, answer: Future[T]) -> bool:
        """True if the answer is ready."""
        return answer.done()


def _wait(answer: Future[T], timeout_s: float) -> None:
    """Wait until the answer is ready (or failed, which the caller detects) or the time is up."""
    try:
        answer.exception(timeout=timeout_s)
    except TimeoutError:
        # The caller checks whether the answer is done.
        return


CHOICES = "lockstep, latency:SECONDS, latency:measured or wall"


def make_clock(text: str) -> DeliveryClock:
    """Create a clock from its name.

    Args:
        text: `lockstep`, `latency:SECONDS`, `latency:measured` or `wall`.

    Raises:
        ValueError: The name is unknown or the latency is not a number of seconds.
    """
    if text == "lockstep":
        return Lockstep()
    if text == "wall":
        return WallClock()
    if text == "latency:measured":
        return MeasuredLatency()
    if text.startswith("latency:"):
        try:
            return FixedLatency(float(text.removeprefix("latency:")))
        except ValueError as error:
            raise ValueError(f"clock {text!r}: {error}; use {CHOICES}") from error
    raise ValueError(f"unknown clock {text!r}: use {CHOICES}")
