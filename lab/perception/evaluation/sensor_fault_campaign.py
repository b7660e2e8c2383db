"""Drives each sensor fault on a few routes and counts the consequences: collisions, waits and requests for help.

`python -m lab.perception.evaluation.sensor_fault_campaign --suite dev --routes 1021,1063 --out DIR`. A fault starts 8 s
after the start of the drive. Routes that are already in DIR are not driven again.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TextIO

from stucksolver.atomic_files import OutputError, require_writable
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.routes import Route, RouteFileError
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.pool import run_tasks
from stucksolver_eval.runner.route_process import RouteTask
from stucksolver_eval.suites import SuiteError, load_routes
from stucksolver_eval.systems.factory import SystemSpecError, check_arm
from stucksolver_eval.systems.spec import SENSORS, SystemSpec
from stucksolver_perception.carla import FAULTS

HEALTHY = "none"
"""Name of the baseline: the same routes without a fault."""
STANDS_M = 0.3
"""Progress in a second below which the ego counts as stopped (m). Ours."""
COLLISION = "collisions_"
"""Prefix of the kinds of collisions; contacts of a stopped ego are not among them."""


class FaultCampaignError(ValueError):
    """A campaign cannot be driven as requested; the message has the reason and the remedy."""


@dataclass(frozen=True)
class FaultCampaignSpec:
    """A campaign. `faults` are names in `FAULTS`, or `none`; a drive ends after `limit_s` of simulated time."""

    out: Path
    suite: str = "dev"
    only: tuple[str, ...] = ()
    faults: tuple[str, ...] = (HEALTHY, *FAULTS)
    recovery: str = "search"
    driver: str = "behavior:normal"
    limit_s: float | None = 60.0
    """Simulated time after which a drive ends (s); None for no limit. Ours."""
    seed: int = 1
    """Seed of the traffic."""
    maps: str | None = None
    jobs: int = 1
    """Number of drives in parallel."""


@dataclass(frozen=True)
class FaultRow:
    """The consequences of one fault, over all routes that were driven with it."""

    fault: str
    routes: int
    crashed: int
    """Number of drives that crashed; they are not counted otherwise."""
    collisions: tuple[str, ...]
    """`ROUTE at TIME: WHAT` for each collision of the moving ego."""
    stood_s: float
    asked: int
    """Number of drives with a request for help."""
    plans: int
    """Number of executed plans that move the vehicle."""
    driven_m: float


def campaign(spec: FaultCampaignSpec, out: TextIO = sys.stderr) -> list[FaultRow]:
    """Drive the missing routes and return a row for each fault. Progress goes to `out`.

    Raises:
        FaultCampaignError: A fault is unknown.
        SystemSpecError: The driver or the recovery does not exist, or sensor-based perception does not work here.
        SuiteError: There is no such suite or route.
        RouteFileError: The route file cannot be read.
        OutputError: The folder cannot be written to.
    """
    unknown = [fault for fault in spec.faults if fault not in (HEALTHY, *FAULTS)]
    if unknown:
        raise FaultCampaignError(f"unknown sensor fault: {unknown[0]!r}. Choose from {', '.join((HEALTHY, *FAULTS))}")
    routes = load_routes(spec.suite, spec.only)
    check_arm(_arm(spec, HEALTHY))
    require_writable(spec.out)
    tasks = [
        RouteTask(_job(spec, route, fault), spec.out / fault)
        for fault in spec.faults
        for route in routes
        if not ResultStore(spec.out / fault).is_done(route, spec.seed)
    ]
    for news in run_tasks(tasks, spec.jobs):
        if news.outcome is not None:
            fault, outcome = news.task.folder.name, news.outcome
            print(f"{fault} {outcome.route_id}: {outcome.state}, {outcome.wall_s:.0f} s", file=out, flush=True)
    return [_row(spec, fault, routes) for fault in spec.faults]


def counted(fault: str, outcomes: Sequence[RouteOutcome]) -> FaultRow:
    """Return the row of a fault from the outcomes of its drives."""
    driven = [outcome for outcome in outcomes if outcome.state == "driven"]
    hits = [
        f"{item.route_id} at {noted.time_s:.0f} s: {noted.text}"
        for item in driven
        for noted in item.infractions
        if noted.kind.startswith(COLLISION)
    ]
    return FaultRow(
        fault=fault,
        routes=len(driven),
        crashed=len(outcomes) - len(driven),
        collisions=tuple(hits),
        stood_s=sum(_stood_s(item.track) for item in driven),
        asked=sum(item.asked_s is not None for item in driven),
        plans=sum(plan.moves for item in driven for plan in item.interventions),
        driven_m=sum(max((place for _, place in item.track), default=0.0) for item in driven),
    )


def as_table(rows: Sequence[FaultRow]) -> str:
    """Return a Markdown table, followed by a line for each collision."""
    lines = [
        "| fault | routes | collisions | stood (s) | asked for help | plans | driven (m) |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        routes = f"{row.routes}, {row.crashed} crashed" if row.crashed else str(row.routes)
        cells = (
            row.fault,
            routes,
            len(row.collisions),
            f"{row.stood_s:.0f}",
            row.asked,
            row.plans,
            f"{row.driven_m:.0f}",
        )
        lines.append(f"| {' | '.join(map(str, cells))} |")
    lines += [f"\n{row.fault}, {hit}" for row in rows for hit in row.collisions]
    return "\n".join(lines)


def _stood_s(track: Sequence[tuple[float, float]]) -> float:
    """Return the time without progress (s); `track` has (time, position) once per second."""
    return sum(later[0] - sooner[0] for sooner, later in pairwise(track) if later[1] - sooner[1] < STANDS_M)


def _row(spec: FaultCampaignSpec, fault: str, routes: Sequence[Route]) -> FaultRow:
    found = (ResultStore(spec.out / fault).outcome(route, spec.seed) for route in routes)
    return counted(fault, [outcome for outcome in found if outcome is not None])


def _job(spec: FaultCampaignSpec, route: Route, fault: str) -> RouteJob:
    arm = _arm(spec, fault)
    return RouteJob(route=route, seed=spec.seed, arm=arm, maps=spec.maps, replays="failed", limit_s=spec.limit_s)


def _arm(spec: FaultCampaignSpec, fault: str) -> SystemSpec:
    failing = "" if fault == HEALTHY else fault
    return SystemSpec(driver=spec.driver, recovery=spec.recovery, perception=SENSORS, sensor_fault=failing)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a campaign and print its table; return 1 if a drive crashed, 2 for a wrong request, else 0."""
    parser = argparse.ArgumentParser(description="Drives each sensor fault on a few routes.")
    parser.add_argument("--out", type=Path, required=True, help="folder for the drives")
    parser.add_argument("--suite", default="dev")
    parser.add_argument("--routes", default="", metavar="ID,ID", help="only these routes of the suite")
    parser.add_argument(
        "--faults", default="", metavar="NAME,NAME", help="only these faults (default: all, and `none`)"
    )
    parser.add_argument("--recovery", default="search")
    parser.add_argument("--limit-s", type=float, default=60.0, help="simulated seconds after which a drive ends")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="number of drives in parallel")
    parser.add_argument("--maps", default=os.environ.get("STUCKSOLVER_MAPS"), help="folders with towns")
    args = parser.parse_args(arguments)
    spec = FaultCampaignSpec(
        out=args.out,
        suite=args.suite,
        only=tuple(filter(None, args.routes.split(","))),
        faults=tuple(filter(None, args.faults.split(","))) or (HEALTHY, *FAULTS),
        recovery=args.recovery,
        limit_s=args.limit_s,
        seed=args.seed,
        maps=args.maps,
        jobs=args.jobs,
    )
    try:
        rows = campaign(spec)
    except (FaultCampaignError, SystemSpecError, SuiteError, RouteFileError, OutputError) as error:
        # The error is printed as one line, without a traceback.
        print(f"fault_campaign: {error}", file=sys.stderr)
        return 2
    print(as_table(rows))
    return 1 if any(row.crashed for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
