"""Runs several routes in parallel on this machine, each in a separate process."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from stucksolver.atomic_files import OutputError
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.runner.isolated_process import RunCancelledError
from stucksolver_eval.runner.route_process import RouteTask, run_task


@dataclass(frozen=True)
class RouteProgress:
    """Progress of a route (`outcome` is None), its outcome, or the error of writing its result (`error`)."""

    task: RouteTask
    time_s: float = 0.0
    outcome: RouteOutcome | None = None
    error: OutputError | None = None


Runner = Callable[[RouteTask, Callable[[float], None], Callable[[], bool]], RouteOutcome]
"""Runs a task.

Its arguments are the task, a progress callback, and a check whether to continue; otherwise it
raises `RunCancelledError`.
"""


def run_tasks(tasks: Iterable[RouteTask], at_once: int, runner: Runner = run_task) -> Iterator[RouteProgress]:
    """Run all tasks, `at_once` in parallel, and yield their progress and results. Raises `OutputError`.

    If the caller stops iterating, or the program ends, the running processes are ended first.
    """
    waiting: queue.SimpleQueue[RouteTask | None] = queue.SimpleQueue()
    ending = threading.Event()
    news: queue.SimpleQueue[RouteProgress] = queue.SimpleQueue()
    todo = list(tasks)
    for task in todo:
        waiting.put(task)
    # Daemon threads, so that a second Ctrl-C does not wait for them.
    threads = [
        threading.Thread(target=_work, args=(waiting, news, runner, ending), daemon=True)
        for _ in range(min(at_once, len(todo)))
    ]
    for thread in threads:
        waiting.put(None)
        thread.start()
    left = len(todo)
    try:
        while left:
            progress = news.get()
            if progress.error is not None:
                raise progress.error
            left -= progress.outcome is not None
            yield progress
    finally:
        ending.set()
        # The threads must end here. At the interpreter's end, a thread that just starts a process would wait for the
        # end of the process.
        for thread in threads:
            thread.join()


def _work(
    waiting: queue.SimpleQueue[RouteTask | None],
    news: queue.SimpleQueue[RouteProgress],
    runner: Runner,
    ending: threading.Event,
) -> None:
    while (task := waiting.get()) is not None and not ending.is_set():
        try:
            outcome = runner(task, _teller(task, news), lambda: not ending.is_set())
        except RunCancelledError:
            # The pool is ending, and with it this thread.
            return
        except OutputError as error:
            # The results cannot be written, so the caller ends the pool.
            news.put(RouteProgress(task, error=error))
            return
        news.put(RouteProgress(task, outcome=outcome))


def _teller(task: RouteTask, news: queue.SimpleQueue[RouteProgress]) -> Callable[[float], None]:
    return lambda time_s: news.put(RouteProgress(task, time_s=time_s))
