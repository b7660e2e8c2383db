"""`stucksolver perception`: recordings of drives, training, and scores."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from stucksolver.cli.arguments import Parser, above_zero, add_maps, add_server, at_least, whole
from stucksolver.cli.errors import UsageError
from stucksolver.cli.words import driver_name


def add_options(parser: argparse.ArgumentParser) -> None:
    """What the command is told."""
    parts = parser.add_subparsers(required=True, metavar="PART", parser_class=Parser)
    _add_collect(parts.add_parser("collect", help="drive routes, and record the sensors with the truth beside them"))


def run(options: argparse.Namespace) -> int:
    """Run the part that was asked for. Raises `UsageError`."""
    return int(options.part(options))


def _add_collect(parser: argparse.ArgumentParser) -> None:
    parser.set_defaults(part=_collect)
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--suite", default="", help="bench220, dev, immobilized, or a leaderboard route file")
    where.add_argument(
        "--towns", default="", metavar="TOWN,TOWN", help="random drives here, amid a crowd of everything"
    )
    parser.add_argument("--routes", default="", metavar="ID,ID", help="only these routes of the suite")
    parser.add_argument("--drives", type=at_least(1), default=1, help="random drives in each town")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for recordings; goes on there")
    parser.add_argument("--jobs", type=at_least(1), default=2, help="routes driven at a time")
    parser.add_argument("--seed", type=whole, default=1, help="of traffic, weather, crowd and random routes")
    parser.add_argument("--limit-s", type=above_zero, default=60.0, metavar="S", help="simulated time of a drive")
    parser.add_argument("--driver", default="behavior", help="behavior or planner, both with :PROFILE")
    parser.add_argument("--weather", choices=("random", "route"), default="random", help="where the weather comes from")
    parser.add_argument("--every", type=float, default=1.0, metavar="S", help="a window of ticks so often; 0 keeps all")
    add_maps(parser)
    add_server(parser)


def _collect(options: argparse.Namespace) -> int:
    from stucksolver_eval.arms.make import ArmError
    from stucksolver_eval.files import OutputError
    from stucksolver_eval.perception.collect import CollectSpec, collect
    from stucksolver_eval.perception.towns import TownError
    from stucksolver_eval.routes import RouteFileError
    from stucksolver_eval.server import ServerError
    from stucksolver_eval.suites import SuiteError

    if options.every and not 0.6 <= options.every <= 60.0:
        raise UsageError("--every: give 0, or from 0.6 to 60 seconds")
    spec = CollectSpec(
        out=options.out,
        suite=options.suite,
        only=_names(options.routes),
        towns=_names(options.towns),
        drives=options.drives,
        jobs=options.jobs,
        seed=options.seed,
        limit_s=options.limit_s,
        driver=driver_name(options.driver),
        random_weather=options.weather == "random",
        every_s=options.every,
        maps=options.maps,
        host=options.host,
        port=options.port,
    )
    try:
        found = collect(spec)
    except (ArmError, OutputError, TownError, RouteFileError, ServerError, SuiteError) as error:
        raise UsageError(str(error)) from error
    print(f"{found.done} recordings in {options.out}; {len(found.failed)} routes failed", file=sys.stdout)
    for line in found.failed:
        print(f"  {line}")
    return 1 if found.failed else 0


def _names(text: str) -> tuple[str, ...]:
    return tuple(filter(None, text.split(",")))
