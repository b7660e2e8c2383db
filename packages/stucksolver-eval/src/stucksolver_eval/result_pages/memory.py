"""Measures the value of a memory: runs at held-out positions before lessons, after each of them, and after bad advice.

```sh
python -m stucksolver_eval.result_pages.memory OUT          # writes results/memory.md
```

A passenger helps at three positions where rocks lie from curb to curb ("please take another street"). After each of
these lessons the car drives at two other positions with other seeds and without guidance. The runs are stored in OUT.
"""

from __future__ import annotations

import sqlite3
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from stucksolver.atomic_files import write_text
from stucksolver.ladder import profile_text
from stucksolver.solver import Event, EventKind, QuestionKind
from stucksolver_eval.guidance import ScriptLine, ScriptTrigger
from stucksolver_eval.result_pages import RESULTS
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.route_process import RouteTask, drive_task
from stucksolver_eval.suites import suite
from stucksolver_eval.systems.spec import SystemSpec

SUITE, TYPE = "immobilized", "RocksAcrossRoad"
DESTINATIONS = {
    "3010": (1114.75, -180.0),
    "3011": (760.83, -785.25),
    "3012": (359.17, 5.25),
    "3013": (565.25, -340.0),
    "3014": (-5.25, -180.0),
}
"""Routes of the suite along streets with four lanes, and destinations (m, CARLA's frame) 60 m beyond the next junction.

The suite's own destinations are in the street itself, and no other road leads there.
"""
LESSONS = 3
"""Number of positions at which the passenger helps. The others are held out."""
LESSON_SEED = 1
"""Seed of the runs in which the passenger helps."""
BAD_SEED = 2
"""Seed of the run in which the passenger gives bad advice."""
HELD_OUT_SEEDS = (11, 12)
"""Seeds of the runs in which nobody speaks."""
HELPS = "Please take another street."
HARMS = "Back up a bit."
ARRIVED_PCT = 100.0
"""Route completion from which the car has arrived (%)."""
HEAD = "| held-out drives, nobody speaks | arrived | questions to the passenger | calls for help | driving score |"
ABOUT = """# What a memory is worth

Rocks lie from kerb to kerb across a street with two lanes in each direction. By themselves the rules turn round only
after a minute, and by then the car has called for help. A passenger who says "Please take another street." has it turn
round at once. That is taught at three places, where the car asks and the passenger answers. The drives in the table
are at two other places, with two other seeds, and nobody speaks. For the last row, between two lessons the passenger
gave one piece of bad advice ("Back up a bit."). At the third place nobody had to be asked any more.

Arrived means that the destination was reached within 200 s. The ladder is the default one, except that the solid line
between the directions may be crossed without a yes: a passenger who never answers cannot give one. Each row begins
with a copy of the memory, so what is learned in its drives does not reach the next row. There is no other traffic, so
the seeds change little: read four drives as two places. A memory proposes nothing after one success, and begins to
propose after two ([docs/privacy.md](../docs/privacy.md)).

    python -m stucksolver_eval.result_pages.memory OUT"""


@dataclass(frozen=True)
class MemoryRunResult:
    """The result of one drive: arrived, questions to the passenger, calls for help, and driving score (0 to 100)."""

    arrived: bool
    questions: int
    calls: int
    score: float


def main(out: Path) -> None:
    """Drive everything and write the page. Raises `RunError` and `OutputError`; completed drives stay in `out`."""
    places = {route.id: route for route in suite(SUITE).routes}
    routes = [_with_rocks(places[name], *end) for name, end in DESTINATIONS.items()]
    lessons, held_out = routes[:LESSONS], routes[LESSONS:]
    write_text(out / "ladder.toml", _ladder())
    taught = out / "memory.db"
    rows = [_row("without a memory", _drives(out / "before", held_out, None))]
    for count, route in enumerate(lessons, 1):
        _drive(out / "lessons", route, LESSON_SEED, taught, HELPS)
        memory = _copy(taught, out / f"after-{count}.db")
        rows.append(_row(f"lessons: {count}", _drives(out / f"after-{count}", held_out, memory)))
        if count == 1:
            # Later the memory proposes the solution and asks no question, so bad advice would have no occasion.
            misled = _copy(taught, out / "misled.db")
            _drive(out / "misled", lessons[1], BAD_SEED, misled, HARMS)
            _drive(out / "misled", lessons[2], LESSON_SEED, misled, HELPS)
            drives = _drives(out / "after-misled", held_out, misled)
            last = _row("lessons: 2, and one bad advice between them", drives)
    rows.append(last)
    write_text(RESULTS / "memory.md", page(rows))


def page(rows: Sequence[str]) -> str:
    """Return the page with these rows."""
    line = "|" + "---|" * HEAD.count(" | ") + "---|"
    return "\n".join([ABOUT, "", HEAD, line, *rows, ""])


def _ladder() -> str:
    asked, unasked = 'solid_line = "passenger"', 'solid_line = "autonomous"'
    text = profile_text("default")
    if asked not in text:
        raise ValueError(f"the default ladder has no line {asked!r}; adapt this page to it")
    return text.replace(asked, unasked)


def _with_rocks(route: Route, x_m: float, y_m: float) -> Route:
    end = replace(route.waypoints[-1], x_m=x_m, y_m=y_m)
    return replace(route, waypoints=(route.waypoints[0], end), scenarios=(replace(route.scenarios[0], type=TYPE),))


def _copy(memory: Path, to: Path) -> Path:
    """Copy a memory, so that drives with the copy do not change it. Returns the copy."""
    with sqlite3.connect(memory) as source, sqlite3.connect(to) as copy:
        source.backup(copy)
    return to


def _drives(folder: Path, routes: list[Route], memory: Path | None) -> list[MemoryRunResult]:
    return [_drive(folder, route, seed, memory, None) for route in routes for seed in HELD_OUT_SEEDS]


def _drive(folder: Path, route: Route, seed: int, memory: Path | None, words: str | None) -> MemoryRunResult:
    arm = SystemSpec(recovery="search", ladder=folder.parent / "ladder.toml", memory=memory)
    lines = () if words is None else (ScriptLine(when=ScriptTrigger(asked="passenger"), say=(words,)),)
    store, job = (
        ResultStore(folder),
        RouteJob(route=route, seed=seed, arm=arm, lines=lines, background=False, events=True),
    )
    if not store.is_done(route, seed):
        drive_task(RouteTask(job, folder))
    record, events = store.record(route, seed), store.events(route, seed)
    assert record is not None
    arrived = record.scores.score_route >= ARRIVED_PCT
    return MemoryRunResult(arrived, _asked(events, False), _asked(events, True), record.scores.score_composed)


def _asked(events: tuple[Event, ...], for_help: bool) -> int:
    questions = [e.question for e in events if e.kind is EventKind.ASKED and e.question is not None]
    return sum((question.kind is QuestionKind.ASSISTANCE) == for_help for question in questions)


def _row(name: str, drives: Sequence[MemoryRunResult]) -> str:
    score = sum(run.score for run in drives) / len(drives)
    arrived, asked = sum(run.arrived for run in drives), sum(run.questions for run in drives)
    calls = sum(run.calls for run in drives)
    return f"| {name} | {arrived} of {len(drives)} | {asked} | {calls} | {score:.1f} |"


if __name__ == "__main__":
    main(Path(sys.argv[1]))
