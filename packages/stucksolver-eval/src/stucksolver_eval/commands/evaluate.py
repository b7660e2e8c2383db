"""`stucksolver evaluate`: drives a suite of routes and scores it."""

from __future__ import annotations

import argparse
import contextlib
import shlex
import sys
from dataclasses import replace
from pathlib import Path

from stucksolver.commands.arguments import add_clock, add_json, add_maps, add_perception, add_server, at_least, whole
from stucksolver.commands.errors import UsageError
from stucksolver_eval.commands.ride import add_page, page_server
from stucksolver_eval.commands.run_arguments import clock_name, driver_name
from stucksolver_eval.commands.score import SCORES, show_scores, show_sweep
from stucksolver_language.commands.api_keys import add_send_key
from stucksolver_passenger.commands.memory import add_memory

REPLAYS = ("none", "failed", "all")
INTERRUPTED = "interrupted; finished routes are stored: run the same command with --resume to continue"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    suites = "bench220, dev, immobilized, reported, or a leaderboard route file"
    parser.add_argument("--suite", required=True, help=suites)
    parser.add_argument("--routes", default="", metavar="ID,ID", help="only these routes of the suite")
    parser.add_argument(
        "--driver",
        default="behavior",
        help="behavior or planner, each with :cautious|normal|aggressive, or your own agent as MODULE:CLASS[@FILE]",
    )
    parser.add_argument("--recovery", default="none", help="none, timers, search, faulty:NAME or another reasoner")
    parser.add_argument("--reasoner", default="", metavar="NAME", help="reasoner for the ladder's rung `model`")
    add_send_key(parser)
    parser.add_argument(
        "--ladder", type=Path, metavar="FILE", help="escalation policy (default: the evaluation profile)"
    )
    parser.add_argument(
        "--guidance",
        type=Path,
        metavar="SCRIPT",
        help="utterances of a passenger by route: a guidance script, or `shipped` for the suite's own",
    )
    add_clock(parser)
    add_perception(parser)
    parser.add_argument(
        "--sensor-fault",
        default="",
        metavar="NAME",
        help="experiment: a sensor that fails during the drive, such as lidar-missing",
    )
    parser.add_argument("--jobs", type=at_least(1), default=2, help="number of routes driven in parallel")
    parser.add_argument("--seed", type=whole, default=1, help="seed of traffic and wordings")
    parser.add_argument("--seeds", metavar="N,N", help="several seeds, instead of --seed")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for results")
    parser.add_argument("--resume", action="store_true", help="continue the evaluation in DIR")
    parser.add_argument(
        "--reuse",
        type=Path,
        metavar="DIR",
        help="copy results from DIR, an evaluation of the same system without guidance or --reasoner (or, with "
        "--recovery "
        "none, one with a recovery): routes on which these make no difference",
    )
    parser.add_argument("--replays", choices=REPLAYS, default="failed", help="routes with a stored replay")
    parser.add_argument(
        "--pictures", action="store_true", help="store a camera picture with each decision of a replay (slower)"
    )
    parser.add_argument("--record", action="store_true", help="store a hash-chained record of each intervention")
    parser.add_argument("--unguarded", action="store_true", help="experiment: execute proposed plans without the guard")
    parser.add_argument(
        "--heedless",
        action="store_true",
        help="experiment: while the driver follows a plan's path, it does not brake for other road users",
    )
    add_maps(parser)
    parser.add_argument(
        "--passenger", action="store_true", help="drive in real time, with a page for conversation with the cars"
    )
    add_page(parser)
    add_memory(parser)
    add_server(parser)
    parser.add_argument("--cluster", metavar="ADDRESS", help="run the routes on the workers of a dask scheduler")
    parser.add_argument(
        "--sweep",
        action="append",
        default=[],
        metavar="NAME=A,B",
        help="values of the detector's v_min (km/h) or dt (s); one evaluation for each combination",
    )
    add_json(parser, SCORES)


def run(options: argparse.Namespace) -> int:
    """Run the evaluation and print the scores; returns the exit code of `show_scores`. Raises `UsageError`."""
    from stucksolver.atomic_files import OutputError
    from stucksolver.ladder import LadderError
    from stucksolver_carla.client_connection import ServerError
    from stucksolver_eval.guidance import GuidanceError
    from stucksolver_eval.results.store import StoreError
    from stucksolver_eval.routes import RouteFileError
    from stucksolver_eval.runner.cluster import ClusterError
    from stucksolver_eval.runner.evaluate import EvaluationSpec, evaluate
    from stucksolver_eval.runner.sweep import SweepError, parse_sweep, run_sweep
    from stucksolver_eval.scenarios.scenario import ScenarioError
    from stucksolver_eval.suites import SuiteError, shipped_guidance
    from stucksolver_eval.systems.factory import SystemSpecError
    from stucksolver_eval.systems.spec import SystemSpec

    errors = (SystemSpecError, OutputError, GuidanceError, StoreError, RouteFileError, ClusterError, SuiteError)
    try:
        spec = EvaluationSpec(
            suite=options.suite,
            out=options.out,
            arm=SystemSpec(
                driver=driver_name(options.driver),
                recovery=options.recovery,
                reasoner=options.reasoner,
                clock=_clock(options.clock),
                perception=options.perception,
                sensor_fault=options.sensor_fault,
                ladder=options.ladder,
                memory=options.memory,
                guarded=not options.unguarded,
                heedless=options.heedless,
                camera=_pictures(options),
            ),
            seeds=_seeds(options),
            only=tuple(filter(None, options.routes.split(","))),
            guidance=shipped_guidance(options.suite) if options.guidance == Path("shipped") else options.guidance,
            maps=options.maps,
            jobs=options.jobs,
            replays=options.replays,
            record=_record(options),
            resume=options.resume,
            reuse=options.reuse,
            host=options.host,
            port=options.port,
            cluster=options.cluster,
            command="stucksolver " + shlex.join(sys.argv[1:]),
        )
        if options.passenger and (options.sweep or options.cluster):
            raise UsageError(
                "--passenger works only for one evaluation on this machine: leave out --sweep and --cluster"
            )
        if options.sweep:
            return show_sweep(run_sweep(spec, parse_sweep(options.sweep)), spec.out, as_json=options.json)
        with contextlib.ExitStack() as page:
            if options.passenger:
                server = page.enter_context(page_server(options))
                print(f"all cars: {server.url(server.tokens.operator())}", file=sys.stderr, flush=True)
                spec = replace(spec, passenger=server.address)
            return show_scores([evaluate(spec).folder], as_json=options.json)
    except KeyboardInterrupt:
        # Finished routes are stored, so an interruption is a normal end.
        print(f"\n{INTERRUPTED}", file=sys.stderr)
        return 130
    except (*errors, ScenarioError, ServerError, LadderError, SweepError) as error:
        raise UsageError(str(error)) from error


def _clock(text: str) -> str:
    name = clock_name(text)
    if name == "wall":
        raise UsageError("clock 'wall' is for live stacks: use lockstep, latency:SECONDS or latency:measured")
    return name


def _pictures(options: argparse.Namespace) -> bool:
    if options.pictures and options.replays == "none":
        raise UsageError("--pictures belong to replays: leave out --pictures, or --replays none")
    return bool(options.pictures) and options.recovery not in ("none", "timers")


def _record(options: argparse.Namespace) -> bool:
    if options.record and options.unguarded:
        raise UsageError("--record needs the guard's verdicts: leave out --record or --unguarded")
    return bool(options.record)


def _seeds(options: argparse.Namespace) -> tuple[int, ...]:
    if options.seeds is None:
        return (options.seed,)
    try:
        seeds = tuple(int(part) for part in options.seeds.split(","))
    except ValueError as error:
        raise UsageError(f"invalid --seeds: {options.seeds}. Give whole numbers such as 1,2,3") from error
    if len(set(seeds)) != len(seeds):
        raise UsageError(f"duplicate seed in --seeds: {options.seeds}. Give each seed once")
    return seeds
