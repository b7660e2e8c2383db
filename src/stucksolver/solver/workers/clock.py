"""When an answer is delivered: the clock is injected, so that a run can be repeated or charged for its thinking."""

from __future__ import annotations

import math
import time
from concurrent.futures import Future, TimeoutError
from dataclasses import dataclass
from typing import Protocol, TypeVar

T = TypeVar("T")
WAIT_LIMIT_S = 60.0
"""Wall time for which a simulated world is held up at most, unless a reasoner's deadline is longer; after that the
answer counts as missing."""


@dataclass
class Pending:
    """One question under way, to a reasoner or to the reader of words."""

    asked_s: float
    asked_wall_s: float
    ticks: int = 0
    """Calls of `step` since it was asked."""
    wait_s: float = WAIT_LIMIT_S
    """How long a simulated world is held up for it."""
    took_s: float | None = None
    """Wall time to the answer, once it is there."""


class Clock(Protocol):
    """Decides at each tick whether an answer may be delivered, and waits for it where time is only simulated."""

    name: str

    def due(self, query: Pending, now_s: float, answer: Future[T]) -> bool:
        """True when the answer is to be taken now. It is there, unless the reasoner hangs."""


class Lockstep:
    """Delivered on the next tick, whatever the wall time (as CARLA's leaderboard has it)."""

    name = "lockstep"

    def due(self, query: Pending, now_s: float, answer: Future[T]) -> bool:
        """At once: waits for the answer while the world stands still."""
        _wait(answer, query.wait_s)
        return True


class Latency:
    """Delivered after a fixed time of a world that goes on."""

    def __init__(self, latency_s: float) -> None:
        if not 0 <= latency_s < math.inf:
            raise ValueError(f"latency must be 0 s or more, and finite, not {latency_s}")
        self.latency_s = latency_s
        self.name = f"latency:{latency_s:g}"

    def due(self, query: Pending, now_s: float, answer: Future[T]) -> bool:
        """When the latency is over in the world's time."""
        if now_s - query.asked_s < self.latency_s - 1e-6:
            return False
        _wait(answer, query.wait_s)
        return True


class Measured:
    """Delivered after as many ticks as it took on the wall; not repeatable."""

    name = "latency:measured"

    def due(self, query: Pending, now_s: float, answer: Future[T]) -> bool:
        """When as much time has gone by in the world as the answer took."""
        simulated = now_s - query.asked_s
        if not answer.done():
            _wait(answer, max(query.asked_wall_s + simulated - time.monotonic(), 0.0))
        if not answer.done():
            return False
        took = query.took_s if query.took_s is not None else time.monotonic() - query.asked_wall_s
        per_tick = simulated / max(query.ticks, 1)
        return per_tick <= 0 or query.ticks >= math.ceil(took / per_tick)


class Wall:
    """Delivered as soon as it is there; never waits. For live stacks."""

    name = "wall"

    def due(self, query: Pending, now_s: float, answer: Future[T]) -> bool:
        """When the answer is there."""
        return answer.done()


def _wait(answer: Future[T], timeout_s: float) -> None:
    """Until the answer is there (or failed, which the taker finds out), or the time is up."""
    try:
        answer.exception(timeout=timeout_s)
    except TimeoutError:
        return


CHOICES = "lockstep, latency:SECONDS, latency:measured or wall"


def make_clock(text: str) -> Clock:
    """`lockstep`, `latency:SECONDS`, `latency:measured` or `wall`. Raises `ValueError` for anything else."""
    if text == "lockstep":
        return Lockstep()
    if text == "wall":
        return Wall()
    if text == "latency:measured":
        return Measured()
    if text.startswith("latency:"):
        try:
            return Latency(float(text.removeprefix("latency:")))
        except ValueError as error:
            raise ValueError(f"clock {text!r}: {error}; use {CHOICES}") from error
    raise ValueError(f"unknown clock {text!r}: use {CHOICES}")
