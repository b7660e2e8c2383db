"""What a memory is worth: held-out places before lessons, after them, and after one bad advice, as a table.

    python -m stucksolver_eval.pages.memory OUT

A passenger helps at three places where rocks lie from kerb to kerb ("please take another street"); then the car
drives at two other places, with other seeds, and nobody says a word. The ladder is our default: who is asked and does
not answer is not there. Each of the three columns drives the same held-out routes; what was driven stays in OUT.
"""

from __future__ import annotations

import sqlite3
import sys
from dataclasses import dataclass, replace
from pathlib import Path

from stucksolver.ladder import profile_text
from stucksolver.solver import Event, EventKind, QuestionKind
from stucksolver_eval.arms.spec import ArmSpec
from stucksolver_eval.files import write_text
from stucksolver_eval.guidance import Line, When
from stucksolver_eval.results.store import Store
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.work import Task, drive_task
from stucksolver_eval.suites import suite

SUITE, PLACES, TYPE = "immobilized", "ClosedRoad", "RocksAcrossRoad"
"""Places of one type, with what stands there replaced by the other's."""
LESSONS = 3
"""Places at which the passenger helps; the others are held out."""
LESSON_SEED, BAD_SEED, HELD_OUT_SEEDS = 1, 2, (11, 12)
HELPS, HARMS = "Please take another street.", "Back up a bit."
HEAD = "| held-out drives, nobody speaks | arrived | questions to the passenger | calls for help | driving score |"


@dataclass(frozen=True)
class Outcome:
    """Of one drive: did it arrive, how many questions were put to the passenger and to the operator, its score."""

    arrived: bool
    questions: int
    calls: int
    score: float


def main(out: Path) -> None:
    """Drive it all and print the table. Raises `RunError` and `OutputError`; what was driven before stays."""
    routes = [_with_rocks(route) for route in suite(SUITE).routes if route.scenarios[0].type == PLACES]
    lessons, held_out = routes[:LESSONS], routes[LESSONS:]
    write_text(out / "ladder.toml", profile_text("default"))
    taught = out / "memory.db"
    print(HEAD, "|" + "---|" * HEAD.count(" | ") + "---|", sep="\n", flush=True)
    _row("without a memory", _drives(out / "before", held_out, None))
    for route in lessons:
        _drive(out / "lessons", route, LESSON_SEED, taught, HELPS)
    _row(f"after {len(lessons)} lessons", _drives(out / "after", held_out, _copy(taught, out / "after.db")))
    _drive(out / "bad", lessons[0], BAD_SEED, taught, HARMS)
    _row("after one bad advice more", _drives(out / "after-bad", held_out, _copy(taught, out / "after-bad.db")))


def _with_rocks(route: Route) -> Route:
    return replace(route, scenarios=(replace(route.scenarios[0], type=TYPE),))


def _copy(memory: Path, to: Path) -> Path:
    """Each column learns by itself from the same beginning."""
    with sqlite3.connect(memory) as source, sqlite3.connect(to) as copy:
        source.backup(copy)
    return to


def _drives(folder: Path, routes: list[Route], memory: Path | None) -> list[Outcome]:
    return [_drive(folder, route, seed, memory, None) for route in routes for seed in HELD_OUT_SEEDS]


def _drive(folder: Path, route: Route, seed: int, memory: Path | None, words: str | None) -> Outcome:
    arm = ArmSpec(recovery="rules", ladder=folder.parent / "ladder.toml", memory=memory)
    lines = () if words is None else (Line(when=When(asked="passenger"), say=(words,)),)
    store, job = Store(folder), RouteJob(route=route, seed=seed, arm=arm, lines=lines, events=True)
    if not store.is_done(route, seed):
        drive_task(Task(job, folder))
    record, events = store.record(route, seed), store.events(route, seed)
    assert record is not None
    return Outcome(record.success, _asked(events, False), _asked(events, True), record.scores.score_composed)


def _asked(events: tuple[Event, ...], for_help: bool) -> int:
    questions = [e.question for e in events if e.kind is EventKind.ASKED and e.question is not None]
    return sum((one.kind is QuestionKind.ASSISTANCE) == for_help for one in questions)


def _row(name: str, drives: list[Outcome]) -> None:
    score = sum(one.score for one in drives) / len(drives)
    arrived, asked = sum(one.arrived for one in drives), sum(one.questions for one in drives)
    calls = sum(one.calls for one in drives)
    print(f"| {name} | {arrived} of {len(drives)} | {asked} | {calls} | {score:.1f} |", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
