"""Collects recordings: drives routes of a suite, or random routes in towns, and records the sensor data."""

from __future__ import annotations

import dataclasses
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import TextIO

from lab.perception.recording.town_routes import town_routes
from stucksolver.atomic_files import require_writable
from stucksolver_eval.drivers.factory import USUAL
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.pool import RouteProgress, run_tasks
from stucksolver_eval.runner.recording_spec import RecordingSpec
from stucksolver_eval.runner.route_process import RouteTask
from stucksolver_eval.suites import load_routes
from stucksolver_eval.suites.weather_presets import PRESETS, weather, weather_name
from stucksolver_eval.systems.factory import check_arm
from stucksolver_eval.systems.spec import SystemSpec

PROFILES = ("cautious", "normal", "aggressive")
LOG = ".drives"
"""Folder of the outcomes; a route with an outcome is done."""


@dataclass(frozen=True)
class CollectSpec:
    """The recordings to make: a `suite` (or route file), or `drives` random routes in each of `towns`."""

    out: Path
    suite: str = ""
    only: tuple[str, ...] = ()
    towns: tuple[str, ...] = ()
    drives: int = 1
    """Number of random routes in each town."""
    jobs: int = 2
    """Number of drives in parallel."""
    seed: int = 1
    """Seed of traffic, weather, pedestrians and random routes."""
    limit_s: float = 60.0
    """Longest simulated time of a drive (s)."""
    driver: str = "behavior:normal"
    random_weather: bool = True
    every_s: float = 1.0
    """Interval between the stored windows of ticks (s); 0 stores all."""
    maps: str | None = None
    host: str | None = None
    port: int = 2000
    """Port of a given server."""


@dataclass(frozen=True)
class CollectResult:
    """Present number of drives in the folder, and a line with the reason for each that failed."""

    done: int
    failed: tuple[str, ...]


def collect(spec: CollectSpec, out: TextIO = sys.stderr) -> CollectResult:
    """Drive the routes that have not been recorded yet. Progress goes to `out`.

    Raises:
        SystemSpecError: There is no such driver.
        SuiteError: There is no such suite or route.
        RouteFileError: The route file cannot be read.
        TownError: A town has no suitable routes.
        OutputError: The folder cannot be written to.
        ServerError: The given server does not respond.
    """
    check_arm(SystemSpec(driver=spec.driver))
    routes = _routes(spec)
    require_writable(spec.out)
    store = ResultStore(spec.out / LOG)
    tasks = [RouteTask(_job(spec, route), store.folder) for route in routes if not _is_done(spec, store, route)]
    before, began_s, failed = len(routes) - len(tasks), time.monotonic(), []
    done = before
    if before:
        print(f"{before} of {len(routes)} routes are recorded already", file=out, flush=True)
    for news in run_tasks(tasks, 1 if spec.host is not None else spec.jobs):
        if news.outcome is None:
            continue
        done += news.outcome.state == "driven"
        if news.outcome.state != "driven":
            failed.append(f"{news.task.job.route.id}: {(news.outcome.reason.splitlines() or ['?'])[-1]}")
        print(_line(news, done + len(failed), len(routes), began_s), file=out, flush=True)
    return CollectResult(done, tuple(failed))


def recording_folder(spec: CollectSpec, route: Route) -> Path:
    """Return the folder of a route's recording."""
    return spec.out / f"{route.town}-{route.id}-{spec.seed}"


def _routes(spec: CollectSpec) -> tuple[Route, ...]:
    if spec.suite:
        found = load_routes(spec.suite, spec.only)
    else:
        found = town_routes(spec.towns, spec.drives, spec.seed, spec.maps, spec.host, spec.port)
    if not spec.random_weather:
        return found
    return tuple(dataclasses.replace(item, weathers=weather(_weather_number(spec, item))) for item in found)


def _weather_number(spec: CollectSpec, route: Route) -> int:
    return Random(f"{spec.seed}:{route.id}").randrange(len(PRESETS))


def _job(spec: CollectSpec, route: Route) -> RouteJob:
    recording = RecordingSpec(
        recording_folder(spec, route),
        every_s=spec.every_s,
        weather=weather_name(_weather_number(spec, route)) if spec.random_weather else "route",
        factory="lab.perception.recording.drive_recorder:DriveRecorder",
        crowd="" if spec.suite else "lab.perception.recording.scattered_objects:Crowd",
    )
    return RouteJob(
        route=route,
        seed=spec.seed,
        arm=SystemSpec(driver=_driver(spec, route)),
        maps=spec.maps,
        # A crowd has its own traffic, of all kinds.
        background=bool(spec.suite),
        limit_s=spec.limit_s,
        recording=recording,
        host=spec.host,
        port=spec.port,
    )


def _driver(spec: CollectSpec, route: Route) -> str:
    """Return the driver of a route. Random drives use all profiles, for a range of speeds."""
    name, _, profile = spec.driver.partition(":")
    if spec.suite or profile != USUAL:
        return spec.driver
    return f"{name}:{Random(f'{spec.seed}:{route.id}:temper').choice(PROFILES)}"


def _is_done(spec: CollectSpec, store: ResultStore, route: Route) -> bool:
    found = store.outcome(route, spec.seed)
    return found is not None and found.state == "driven" and (recording_folder(spec, route) / "drive.json").is_file()


def _line(news: RouteProgress, done: int, total: int, began_s: float) -> str:
    outcome = news.outcome
    assert outcome is not None
    name = f"[{done}/{total}] {news.task.job.route.id} {news.task.job.scenario} ({news.task.job.route.town})"
    if outcome.state != "driven":
        return f"{name}: {outcome.state}: {(outcome.reason.splitlines() or ['?'])[-1]}"
    left = (time.monotonic() - began_s) / 60.0
    return f"{name}: {outcome.ticks * 0.05:.0f} s in {outcome.wall_s:.0f} s; {left:.0f} min so far"
