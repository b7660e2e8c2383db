"""Runs an evaluation: checks the request first, resumes earlier results, and displays progress."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stucksolver.atomic_files import require_writable
from stucksolver.ladder import find_ladder
from stucksolver.reasoners.factory import sees
from stucksolver_carla.client_connection import check_remote
from stucksolver_eval.guidance import Script, read_script
from stucksolver_eval.passenger import PassengerSpec
from stucksolver_eval.results.manifest import EvaluationManifest, file_digest, suite_digest
from stucksolver_eval.results.store import DONE, ResultStore, StoreError
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.job import Replays, RouteJob
from stucksolver_eval.runner.map_preflight import require_maps
from stucksolver_eval.runner.pool import RouteProgress, run_tasks
from stucksolver_eval.runner.progress import ProgressDisplay
from stucksolver_eval.runner.route_process import RouteTask
from stucksolver_eval.scenarios.registry import scenario_type
from stucksolver_eval.suites import load_routes, route_ids
from stucksolver_eval.systems.factory import NONE, check_arm, preflight_arm
from stucksolver_eval.systems.spec import SystemSpec
from stucksolver_language.llm.prompt import prompt_name


@dataclass(frozen=True)
class EvaluationSpec:
    """Options of an evaluation. With `host` and `port` of a running CARLA server, routes are driven one at a time."""

    suite: str
    out: Path
    arm: SystemSpec = field(default_factory=SystemSpec)
    seeds: tuple[int, ...] = (1,)
    only: tuple[str, ...] = ()
    guidance: Path | None = None
    maps: str | None = None
    jobs: int = 2
    replays: Replays = "failed"
    record: bool = False
    resume: bool = False
    reuse: Path | None = None
    """An evaluation of the same system without guidance, without the reasoner of the rung `model`, or without both.

    For the driver alone it is an evaluation of the same driver with a recovery. Results of routes on which none of
    these made a difference are copied from it.
    """
    host: str | None = None
    port: int = 2000
    cluster: str | None = None
    passenger: Path | None = None
    """Address file of a passenger server. People can talk to the cars, which drive in real time."""
    command: str = ""


def evaluate(spec: EvaluationSpec) -> ResultStore:
    """Run the routes that are not done yet. Returns the store with all results.

    Raises `SuiteError`, `RouteFileError`, `ScenarioError` (an unknown type), `SystemSpecError`, `LadderError`,
    `GuidanceError`, `StoreError`, `ServerError` (no server at `host`), `OutputError` and `ClusterError`; all except the
    last two before the first drive.
    """
    routes = load_routes(spec.suite, spec.only)
    for scenario in {s.type for route in routes for s in route.scenarios}:
        scenario_type(scenario)
    check_arm(spec.arm)
    if spec.arm.ladder is not None:
        find_ladder(spec.arm.ladder)
    script = Script(routes={}) if spec.guidance is None else read_script(spec.guidance, route_ids(spec.suite))
    store, manifest = ResultStore(spec.out), manifest_of(spec, routes)
    alike = None if spec.reuse is None else _alike(spec.reuse, manifest)
    if spec.host is not None and spec.cluster is None:
        check_remote(spec.host, spec.port)
    if spec.host is None and spec.cluster is None:
        require_maps(routes, spec.maps)
    for note in (*preflight_arm(spec.arm), *_notes(routes)):
        print(f"note: {note}", file=sys.stderr, flush=True)
    store.begin(manifest, routes, spec.resume)
    require_writable(spec.out)
    if alike is not None:
        _take(store, alike, routes, script, spec.arm)
    tasks = [
        RouteTask(_job(spec, store, route, seed, script), spec.out)
        for seed in spec.seeds
        for route in routes
        if not store.is_done(route, seed)
    ]
    total = len(routes) * len(spec.seeds)
    _watch(store, _run(spec, tasks), ProgressDisplay(total, total - len(tasks), sys.stderr))
    return store


def _notes(routes: tuple[Route, ...]) -> Iterator[str]:
    if not any(route.scenarios for route in routes):
        yield (
            "no route has a scenario: there is background traffic only "
            "(route files of format 1.0 have their scenarios in another file, which is not read)"
        )


def _alike(folder: Path, manifest: EvaluationManifest) -> ResultStore:
    """Return the evaluation to copy routes from.

    Raises `StoreError` if its system differs or it has guidance itself.
    """
    store = ResultStore(folder)
    theirs = store.manifest()
    ours = manifest.model_copy(update={"guidance_digest": ""})
    if _is_alone(manifest):
        ours = ours.model_copy(update={name: getattr(theirs, name) for name in ("recovery", "reasoner", "prompt")})
    # In a user's ladder, other rungs may lie between `model` and the request for assistance, see `_take`.
    if not theirs.reasoner and not manifest.ladder_digest:
        ours = ours.model_copy(update={"reasoner": "", "prompt": theirs.prompt})
    if differs := ours.differs_from(theirs):
        raise StoreError(f"no result to reuse in folder: {folder}: {differs}. Omit --reuse")
    return store


def _take(store: ResultStore, alike: ResultStore, routes: tuple[Route, ...], script: Script, arm: SystemSpec) -> None:
    """Copy the routes with identical results, since runs are repeatable.

    These routes have no guidance. If the other evaluation has no reasoner for the rung `model`, it never requested
    assistance either, which is the next rung after `model`. If only the other one has a recovery, it also never
    intervened. Its queries to the reasoner do not move the vehicle, and the driver alone has none.
    """
    ours, theirs = store.manifest(), alike.manifest()
    fewer = ours.reasoner != theirs.reasoner
    alone = _is_alone(ours) and not _is_alone(theirs)
    for route in routes:
        for seed in store.seeds():
            if script.lines(route.id) or store.is_done(route, seed):
                continue
            found = alike.outcome(route, seed)
            if found is None or found.state not in DONE:
                continue
            changed = found.asked_s is not None or (alone and found.interventions)
            if not ((fewer or alone) and changed):
                update: dict[str, Any] = {"arm": arm.name} | ({"queries": (), "reliability": ()} if alone else {})
                store.take(alike, route, found.model_copy(update=update))


def _is_alone(manifest: EvaluationManifest) -> bool:
    return manifest.recovery == NONE


def _run(spec: EvaluationSpec, tasks: list[RouteTask]) -> Iterator[RouteProgress]:
    if spec.cluster is not None:
        from stucksolver_eval.runner.cluster import run_on_cluster

        return run_on_cluster(tasks, spec.cluster)
    return run_tasks(tasks, 1 if spec.host is not None else spec.jobs)


def _watch(store: ResultStore, news: Iterator[RouteProgress], board: ProgressDisplay) -> None:
    try:
        for progress in news:
            job = progress.task.job
            if progress.outcome is None:
                board.goes_on(progress.task, progress.time_s)
            else:
                record = store.record(job.route, job.seed) if progress.outcome.state == "driven" else None
                board.is_over(progress.task, progress.outcome, record)
    finally:
        board.close()


def _job(spec: EvaluationSpec, store: ResultStore, route: Route, seed: int, script: Script) -> RouteJob:
    return RouteJob(
        route=route,
        seed=seed,
        arm=spec.arm,
        lines=script.lines(route.id),
        maps=spec.maps,
        replays=spec.replays,
        records=store.interventions(route, seed) if spec.record else None,
        passenger=None if spec.passenger is None else _passenger(spec.passenger, route, seed),
        host=spec.host,
        port=spec.port,
    )


def _passenger(address: Path, route: Route, seed: int) -> PassengerSpec:
    return PassengerSpec(address, f"route-{route.id}-{seed}"[:40], f"Route {route.id}, seed {seed}")


def manifest_of(spec: EvaluationSpec, routes: tuple[Route, ...]) -> EvaluationManifest:
    """Return the settings of the evaluation, which are stored with the results."""
    arm = spec.arm
    return EvaluationManifest(
        suite=spec.suite,
        suite_digest=suite_digest(routes),
        routes=len(routes),
        seeds=spec.seeds,
        driver=arm.driver,
        recovery=arm.recovery,
        reasoner=arm.reasoner,
        prompt=prompt_name() if sees(arm.recovery) or sees(arm.reasoner) else "",
        clock=arm.clock,
        perception=arm.perception,
        detector=dict(arm.detector),
        guarded=arm.guarded,
        heedless=arm.heedless,
        guidance="" if spec.guidance is None else spec.guidance.name,
        guidance_digest=file_digest(spec.guidance),
        ladder="" if arm.ladder is None else arm.ladder.name,
        ladder_digest=file_digest(arm.ladder),
        memory="" if arm.memory is None else arm.memory.name,
        simulator="carlette" if spec.host is None else "CARLA server",
        command=spec.command,
    )
