"""Steps that lead to further steps."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from typing import Any

import pytest

from lab.language.plan_search.step_scheduler import Step, StepStage, run_steps


def step(name: str, stage: StepStage, done: list[str], *following: Step) -> Step:
    def then(result: str) -> Iterable[Step]:
        done.append(result)
        return following

    return Step(stage, lambda wanted: name, then)


def test_what_was_begun_is_finished_before_more_is_begun() -> None:
    done: list[str] = []
    routes = [
        step(
            f"reference {k}",
            StepStage.REFERENCE,
            done,
            step(f"search {k}", StepStage.SEARCH, done, step(f"drive {k}a", StepStage.EXACT, done)),
        )
        for k in range(3)
    ]
    run_steps(routes, 1)
    expected = [[f"reference {k}", f"search {k}", f"drive {k}a"] for k in range(3)]
    assert done == [name for item in expected for name in item]


@pytest.mark.parametrize("at_once", [1, 2, 5])
def test_all_steps_run_and_never_more_than_allowed(at_once: int) -> None:
    running, most, lock, done = 0, 0, threading.Lock(), []

    def work(wanted: Callable[[], bool]) -> None:
        nonlocal running, most
        with lock:
            running += 1
            most = max(most, running)
        time.sleep(0.01)
        with lock:
            running -= 1

    def then(result: Any) -> Iterable[Step]:
        done.append(result)
        return [Step(StepStage.EXACT, work, lambda _: done.append("last") or ())]  # type: ignore[func-returns-value]

    run_steps([Step(StepStage.REFERENCE, work, then) for _ in range(7)], at_once)
    assert len(done) == 14
    assert most <= at_once


def test_the_first_error_ends_the_others_and_is_raised() -> None:
    told = threading.Event()

    def patient(wanted: Callable[[], bool]) -> None:
        while wanted():
            time.sleep(0.005)
        told.set()

    def broken(wanted: Callable[[], bool]) -> None:
        raise RuntimeError("disk full")

    with pytest.raises(RuntimeError, match="disk full"):
        run_steps([Step(StepStage.EXACT, item, lambda _: ()) for item in (patient, broken)], 2)
    assert told.is_set()


def test_nothing_to_do_ends_at_once() -> None:
    run_steps([], 3)
