"""The demonstration: a parked car and two slow cyclists, on any map, each without and with what helps."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

import carla

from stucksolver.evaluate.files import write_text
from stucksolver.evaluate.report import write_report
from stucksolver.evaluate.run import DT_S, RunSpec, run
from stucksolver.evaluate.runlog import RunLog
from stucksolver.evaluate.server import Server, ServerError, carlette_server
from stucksolver.evaluate.sites import Site, SiteError, find_sites
from stucksolver.evaluate.situation import Scenario
from stucksolver.evaluate.traffic import Traffic

CLIENT_TIMEOUT_S = 15.0
PARKED_LENGTH_M, CYCLISTS_LENGTH_M = 170, 260
SIGHT_TO_OVERTAKE_M = 250.0
WORDS = (8.0, "please overtake them")
KINDS = {"one_lane": "one lane each way", "multi_lane": "several lanes"}


@dataclass(frozen=True)
class DemoSpec:
    """What to show. `host` and `port`: a running server instead of a carlette of our own."""

    map_name: str = "demo_town"
    maps: str | None = None
    seed: int = 1
    profile: str = "normal"
    road: Literal["one_lane", "multi_lane", "any"] = "any"
    oncoming: int = 0
    clock: str = "lockstep"
    out: Path = Path("out/demo")
    host: str | None = None
    port: int = 2000


def demo(spec: DemoSpec, say: Callable[[str], None]) -> tuple[list[RunLog], Path]:
    """Run everything, keep each run's log as soon as it is there, and write the report last.

    Raises `ServerError`, `SiteError`, `SituationError`, `RouteError`, `ReportError`, `OutputError`.
    """
    runs: list[RunLog] = []
    with _server(spec) as server, _connected(spec, server) as (client, traffic):
        specs = _plan(spec, client.get_world().get_map())
        for k, one in enumerate(specs, 1):
            label = f"[{k}/{len(specs)}] {one.title}: {one.arm}"
            log = _run(one, client, traffic, server, partial(_progress, say, label))
            runs.append(log)
            say(f"{label}: {log.result.status} after {log.result.duration_s:.0f} s\n")
            write_text(spec.out / "runs" / f"{one.scenario.value}-{k}.json", log.model_dump_json())
    report = spec.out / "report.html"
    write_report(runs, report, f"StuckSolver on {Path(spec.map_name).stem}", _notes(spec))
    return runs, report


def _progress(say: Callable[[str], None], label: str, elapsed_s: float) -> None:
    if round(elapsed_s / DT_S) % 100 == 0:
        say(f"{label} … {elapsed_s:.0f} s")


def _run(one: RunSpec, client: Any, traffic: Traffic, server: Server, progress: Callable[[float], None]) -> RunLog:
    try:
        return run(one, client, traffic, progress)
    except RuntimeError as error:
        server.check()
        raise ServerError(f"the simulator at {server.host}:{server.port} does not answer: {error}") from error


@contextlib.contextmanager
def _server(spec: DemoSpec) -> Iterator[Server]:
    if spec.host is not None:
        yield Server(spec.host, spec.port)
        return
    with carlette_server(spec.map_name, spec.maps, spec.seed) as server:
        yield server


@contextlib.contextmanager
def _connected(spec: DemoSpec, server: Server) -> Iterator[tuple[Any, Traffic]]:
    client = carla.Client(server.host, server.port)
    client.set_timeout(CLIENT_TIMEOUT_S)
    traffic = Traffic(client)
    try:
        if spec.host is not None:
            client.load_world(spec.map_name)
        client.get_world()
    except RuntimeError as error:
        raise ServerError(f"no CARLA server answers at {server.host}:{server.port}: {error}") from error
    try:
        yield client, traffic
    finally:
        traffic.close()


def _plan(spec: DemoSpec, carla_map: Any) -> list[RunSpec]:
    parked = find_sites(carla_map, spec.road, spec.seed, PARKED_LENGTH_M)[0]
    cycling = _cycling_site(spec, carla_map)
    runs = []
    for scenario, site, arms in (
        (Scenario.PARKED_CAR, parked, (("driver alone", False, ()), ("StuckSolver", True, ()))),
        (Scenario.CYCLISTS, cycling, (("StuckSolver", True, ()), ("StuckSolver + passenger", True, (WORDS,)))),
    ):
        name = "parked car" if scenario is Scenario.PARKED_CAR else "two slow cyclists"
        cars = spec.oncoming if site.kind == "one_lane" else 0
        title = f"{name}, {KINDS[site.kind]}" + (f", {cars} oncoming" if cars else "")
        for arm, with_solver, guidance in arms:
            runs.append(
                RunSpec(
                    scenario=scenario,
                    site=site,
                    title=title,
                    arm=arm,
                    with_solver=with_solver,
                    guidance=guidance,
                    oncoming=cars,
                    seed=spec.seed,
                    profile=spec.profile,
                    clock=spec.clock,
                )
            )
    return runs


def _cycling_site(spec: DemoSpec, carla_map: Any) -> Site:
    """To overtake riders takes a long way: prefer a place where that much of the oncoming lane can be seen."""
    sites = find_sites(carla_map, spec.road, spec.seed, CYCLISTS_LENGTH_M)
    if not sites:
        raise SiteError(f"map {carla_map.name} has no place for this")
    far = [s for s in sites if s.kind == "multi_lane" or s.oncoming_m >= SIGHT_TO_OVERTAKE_M]
    return (far or sites)[0]


def _notes(spec: DemoSpec) -> list[str]:
    simulator = "a server at the given address" if spec.host else "carlette, the embedded simulator"
    return [
        f"Seed {spec.seed}, driver behavior:{spec.profile}, clock {spec.clock}, simulator: {simulator}.",
        "perception: privileged – scenes are built from the simulator's ground truth, not from sensors.",
        "A solid line may be crossed past a stationary obstruction without asking (the evaluation profile).",
    ]
