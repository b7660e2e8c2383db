"""`stucksolver distill`: collects what a distilled model learns from."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from stucksolver.cli.arguments import Parser, above_zero, add_maps, at_least, whole
from stucksolver.cli.errors import UsageError

INTERRUPTED = "interrupted; what is done is kept: run the same command again to continue"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parts = parser.add_subparsers(required=True, metavar="SUBCOMMAND", help="what to do", parser_class=Parser)
    collect = parts.add_parser("collect", help="search plans for the standstills of a suite, and drive the best ones")
    collect.set_defaults(part=_collect)
    collect.add_argument("--suite", required=True, help="bench220, dev, immobilized, or a leaderboard route file")
    collect.add_argument("--routes", default="", metavar="ID,ID", help="only these routes of the suite")
    collect.add_argument("--seed", type=whole, default=1, help="seed of the traffic")
    collect.add_argument(
        "--best", type=at_least(1), default=10, metavar="N", help="plans driven exactly at each standstill"
    )
    collect.add_argument("--jobs", type=at_least(1), default=2, help="number of routes driven in parallel")
    collect.add_argument("--limit", type=above_zero, metavar="S", help="end every route at this time")
    collect.add_argument("--ladder", type=Path, metavar="FILE", help="escalation policy (default: evaluation)")
    collect.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the campaign")
    add_maps(collect)


def run(options: argparse.Namespace) -> int:
    """Run the requested subcommand and return its exit code. Raises `UsageError`."""
    return int(options.part(options))


def _collect(options: argparse.Namespace) -> int:
    from stucksolver_distill.campaign import CampaignError
    from stucksolver_distill.teacher import Asked, teach
    from stucksolver_eval.files import OutputError
    from stucksolver_eval.routes import RouteFileError
    from stucksolver_eval.suites import SuiteError

    try:
        report = teach(
            Asked(
                suite=options.suite,
                out=options.out,
                seed=options.seed,
                routes=tuple(filter(None, options.routes.split(","))),
                best=options.best,
                jobs=options.jobs,
                ladder=options.ladder,
                maps=options.maps,
                limit_s=options.limit,
            )
        )
    except KeyboardInterrupt:
        print(f"\n{INTERRUPTED}", file=sys.stderr)
        return 130
    except (CampaignError, OutputError, RouteFileError, SuiteError) as error:
        raise UsageError(str(error)) from error
    print(report)
    return 0
