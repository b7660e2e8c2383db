"""Several routes at a time on this machine, each in a process of its own."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from stucksolver_eval.files import OutputError
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.runner.process import NotWanted
from stucksolver_eval.runner.work import Task, run_task


@dataclass(frozen=True)
class News:
    """A route that goes on (`outcome` is None), is over, or whose result could not be written (`error`)."""

    task: Task
    time_s: float = 0.0
    outcome: RouteOutcome | None = None
    error: OutputError | None = None


Runner = Callable[[Task, Callable[[float], None], Callable[[], bool]], RouteOutcome]
"""Takes where to tell of progress, and what says whether the task is wanted still; raises `NotWanted` if not."""


def run_tasks(tasks: Iterable[Task], at_once: int, runner: Runner = run_task) -> Iterator[News]:
    """Run all of them, `at_once` at a time, and tell of each as it goes on. Raises `OutputError`.

    When the caller stops listening, or the program ends, the processes under way are ended first.
    """
    waiting: queue.SimpleQueue[Task | None] = queue.SimpleQueue()
    ending = threading.Event()
    news: queue.SimpleQueue[News] = queue.SimpleQueue()
    todo = list(tasks)
    for task in todo:
        waiting.put(task)
    # Daemons: a second Ctrl-C need not wait for them.
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
            told = news.get()
            if told.error is not None:
                raise told.error
            left -= told.outcome is not None
            yield told
    finally:
        ending.set()
        # Left to the interpreter's end, one that begins a process just then would have it waited for to its end.
        for thread in threads:
            thread.join()


def _work(
    waiting: queue.SimpleQueue[Task | None], news: queue.SimpleQueue[News], runner: Runner, ending: threading.Event
) -> None:
    while (task := waiting.get()) is not None and not ending.is_set():
        try:
            outcome = runner(task, _teller(task, news), lambda: not ending.is_set())
        except NotWanted:
            return
        except OutputError as error:
            news.put(News(task, error=error))
            return
        news.put(News(task, outcome=outcome))


def _teller(task: Task, news: queue.SimpleQueue[News]) -> Callable[[float], None]:
    return lambda time_s: news.put(News(task, time_s=time_s))
