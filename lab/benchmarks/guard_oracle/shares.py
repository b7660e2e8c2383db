"""Shares the scenes of a campaign among processes, and returns their rows in the order of the scenes."""

from __future__ import annotations

import multiprocessing
import os
from collections import deque
from collections.abc import Iterator
from multiprocessing.pool import AsyncResult
from typing import Any

from lab.benchmarks.guard_oracle.campaign import Row, scene_rows
from lab.benchmarks.guard_oracle.scene import number_of

Place = tuple[int, str, int]
Done = tuple[int, str, int, list[Row]]
AHEAD = 8
"""Number of scenes that wait or run for each process, so that one long scene leaves none of them idle."""
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def scenes_in_order(
    seed: int, places: Iterator[Place], judge_only: bool, jobs: int, only: int | None = None
) -> Iterator[Done]:
    """Yield (position, class, number of the scene, rows) of all scenes in order, with any number of processes."""
    if jobs <= 1:
        yield from (_scene(seed, place, judge_only, only) for place in places)
        return
    # Each process uses one core: threads of the numerical libraries would only compete.
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    pending: deque[AsyncResult[Done]] = deque()
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        for place in places:
            pending.append(pool.apply_async(_scene, (seed, place, judge_only, only)))
            if len(pending) >= AHEAD * jobs:
                yield pending.popleft().get()
        while pending:
            yield pending.popleft().get()


def _scene(seed: int, place: Place, judge_only: bool, only: int | None) -> Done:
    """Judge and drive all proposals of one scene."""
    at, name, k = place
    number = number_of(name, k)
    rows: list[dict[str, Any]] = list(scene_rows(seed, number, judge_only, only))
    return at, name, number, rows
