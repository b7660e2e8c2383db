"""Collects samples: drives suites with the driver alone, and stores the times at which it went on by itself.

The folder:

```
moments.json                       the options
moments/SUITE/ROUTE-SEED.jsonl.gz  the samples of one drive; empty without a query
```

A drive with a file is done, so the same command continues an interrupted collection.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path

from stucksolver.reasoners.playback import PlanTable

from lab.language.plan_search.counterfactual_run import DriveSpec, drive_task, questions_of
from lab.language.plan_search.decision_samples import SUFFIX, moments_of, write_moments
from stucksolver.atomic_files import write_text
from stucksolver.guard import Guard
from stucksolver.ladder import find_ladder
from stucksolver.scene.base_model import FrozenModel
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.pool import run_tasks
from stucksolver_eval.runner.route_process import RouteTask, run_task

MANIFEST, MOMENTS, DRIVES = "moments.json", "moments", "drives"
LIMIT_S = 120.0
"""Time limit of a drive (s). Ours.

A standstill is then observed for much longer than the student looks ahead.
"""
Say = Callable[[str], None]


class WaitingError(RuntimeError):
    """The folder cannot be continued; the message has the reason and the remedy."""


class WaitingManifest(FrozenModel):
    """The options of a folder. It continues only with the same ones; suites and seeds may be added."""

    version: int = 1
    """Version of the file."""
    driver: str
    ladder: str
    limit_s: float


@dataclass(frozen=True)
class WaitingSpec:
    """The drives to collect.

    Attributes:
        suite: Name of the suite.
        routes: The routes to drive.
        seeds: Seeds of the traffic; each route is driven with each of them.
        out: The folder.
        jobs: Number of drives in parallel.
        drives: Settings that all drives share.
    """

    suite: str
    routes: tuple[Route, ...]
    seeds: tuple[int, ...]
    out: Path
    jobs: int = 2
    """Number of drives in parallel. Ours."""
    drives: DriveSpec = field(default_factory=lambda: DriveSpec(limit_s=LIMIT_S))


def collect_waits(spec: WaitingSpec, say: Say) -> list[str]:
    """Drive all remaining routes, and return a line for each route that could not be driven.

    Args:
        spec: The drives.
        say: Called with each line of progress.

    Raises:
        WaitingError: The folder was begun with other options.
        OutputError: Something cannot be written.
    """
    _begin(spec)
    todo = [(route, seed) for seed in spec.seeds for route in spec.routes if not _file(spec, route.id, seed).exists()]
    tasks = [_task(spec, route, seed) for route, seed in todo]
    failed: list[str] = []
    done = 0
    with ProcessPoolExecutor(spec.jobs, get_context("spawn")) as readers:

        def drive(task: RouteTask, progress: Callable[[float], None], wanted: Callable[[], bool]) -> RouteOutcome:
            outcome = run_task(task, progress, wanted)
            _store_samples(spec, task, outcome, readers)
            return outcome

        for news in run_tasks(tasks, spec.jobs, drive):
            if news.outcome is None:
                continue
            one, done = news.outcome, done + 1
            say(f"[{done} of {len(tasks)}] {one.route_id}, seed {one.seed}: {one.state}, {len(one.queries)} questions")
            if one.state != "driven":
                failed.append(f"{one.route_id}: {one.reason.strip().splitlines()[-1] if one.reason else one.state}")
    shutil.rmtree(spec.out / DRIVES, ignore_errors=True)
    return failed


def _begin(spec: WaitingSpec) -> None:
    drives = spec.drives
    assert drives.limit_s is not None
    ladder = "" if drives.ladder is None else drives.ladder.name
    manifest = WaitingManifest(driver=drives.driver, ladder=ladder, limit_s=drives.limit_s)
    path = spec.out / MANIFEST
    if not path.exists():
        write_text(path, manifest.model_dump_json(indent=1) + "\n")
    elif WaitingManifest.model_validate_json(path.read_text(encoding="utf-8")) != manifest:
        raise WaitingError(
            f"the folder was begun with other options: {path}. Choose another --out, or use the same options"
        )


def _file(spec: WaitingSpec, route_id: str, seed: int) -> Path:
    return spec.out / MOMENTS / spec.suite / f"{route_id}-{seed}{SUFFIX}"


def _task(spec: WaitingSpec, route: Route, seed: int) -> RouteTask:
    folder = spec.out / DRIVES / f"{spec.suite}-{route.id}-{seed}"
    # The table is empty, so every answer is to wait and the driver drives alone.
    return drive_task(spec.drives, route, seed, PlanTable(), folder, waits=True)


def _store_samples(spec: WaitingSpec, task: RouteTask, outcome: RouteOutcome, readers: Executor) -> None:
    """Store the samples of a drive, and remove everything else. A failed drive is repeated next time."""
    if outcome.state == "driven":
        path = _file(spec, outcome.route_id, outcome.seed)
        readers.submit(keep, spec.suite, spec.drives.ladder, task.folder, outcome, path).result()
    shutil.rmtree(task.folder, ignore_errors=True)


def keep(suite: str, ladder: Path | None, folder: Path, outcome: RouteOutcome, path: Path) -> None:
    """Write the samples of a drive. It runs in a separate process, because it queries the guard thousands of times."""
    guard = Guard(find_ladder(ladder or "evaluation").guard_policy())
    write_moments(path, moments_of(suite, outcome, questions_of(folder), guard))
