"""Runs steps in parallel that lead to further steps, and finishes steps in progress before it starts new ones."""

from __future__ import annotations

import heapq
import itertools
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from enum import IntEnum
from typing import Any


class StepStage(IntEnum):
    """The order of precedence, smallest first."""

    EXACT = 0
    SEARCH = 1
    REFERENCE = 2


@dataclass(frozen=True)
class Step:
    """One piece of work.

    Attributes:
        stage: Its precedence.
        run: Does the work, in a separate thread. Its argument returns False once the work is no longer wanted.
        next_steps: Takes the result in the caller's thread, and returns the steps that follow.
    """

    stage: StepStage
    run: Callable[[Callable[[], bool]], Any]
    next_steps: Callable[[Any], Iterable[Step]]


def run_steps(steps: Iterable[Step], at_once: int) -> None:
    """Run steps and all that follow from them, `at_once` in parallel.

    The first error ends the others, and is raised. Among steps of one stage the earlier ones come first.
    """
    count, ending = itertools.count(), threading.Event()
    ready = [(step.stage, next(count), step) for step in steps]
    heapq.heapify(ready)
    running: dict[Future[Any], Step] = {}
    with ThreadPoolExecutor(at_once) as threads:
        try:
            while ready or running:
                while ready and len(running) < at_once:
                    step = heapq.heappop(ready)[2]
                    running[threads.submit(step.run, lambda: not ending.is_set())] = step
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    for following in running.pop(future).next_steps(future.result()):
                        heapq.heappush(ready, (following.stage, next(count), following))
        finally:
            ending.set()
