"""`python -m lab.language.plan_search.collect_command`: the same as `python -m lab distill collect`."""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

from lab.language.plan_search.beam_search import SearchSettings
from lab.language.plan_search.campaign import PlanSearchSpec, collect
from lab.language.plan_search.counterfactual_run import DriveSpec
from lab.language.plan_search.search_gain import write_report
from stucksolver_eval.suites import load_routes, suite


@dataclass(frozen=True)
class CollectOptions:
    """The options of the command."""

    suite: str
    out: Path
    seed: int = 1
    """Seed of the traffic."""
    routes: tuple[str, ...] = ()
    best: int = 10
    """Number of plans driven exactly at each standstill. Ours."""
    jobs: int = 2
    """Number of drives in parallel. Ours."""
    driver: str = "behavior:normal"
    ladder: Path | None = None
    maps: str | None = None
    limit_s: float | None = None
    beam: int = SearchSettings.beam


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of a campaign."""
    parser.add_argument("--suite", required=True, help="bench220, dev, immobilized, or a leaderboard route file")
    parser.add_argument("--routes", default="", metavar="ID,ID", help="only these routes of the suite")
    parser.add_argument("--seed", type=int, default=1, help="seed of the traffic")
    parser.add_argument("--best", type=int, default=10, metavar="N", help="plans driven exactly at each standstill")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="number of drives in parallel")
    parser.add_argument("--driver", default="behavior:normal", help="driver before and after the standstill")
    parser.add_argument("--ladder", type=Path, metavar="FILE", help="escalation policy (default: evaluation)")
    parser.add_argument("--maps", metavar="DIR", help="an additional folder of maps")
    parser.add_argument("--limit", type=float, metavar="S", help="end every route at this time (default: at its end)")
    parser.add_argument("--beam", type=int, default=SearchSettings.beam, metavar="N", help="width of the beam search")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder; an existing campaign continues")


def parse_options(options: argparse.Namespace) -> CollectOptions:
    """Return the parsed options."""
    return CollectOptions(
        suite=options.suite,
        out=options.out,
        seed=options.seed,
        routes=tuple(filter(None, options.routes.split(","))),
        best=options.best,
        jobs=options.jobs,
        driver=options.driver,
        ladder=options.ladder,
        maps=options.maps,
        limit_s=options.limit,
        beam=options.beam,
    )


def teach(what: CollectOptions) -> Path:
    """Run a campaign, or continue it, and return the path of its report.

    Raises:
        SuiteError: There is no such suite or route.
        RouteFileError: The file of routes is invalid.
        PlanSearchError: The folder contains another campaign, or its labels cannot be read.
        OutputError: Something cannot be written.
    """
    spec = PlanSearchSpec(
        suite=what.suite,
        suite_digest=suite(what.suite).digest,
        routes=load_routes(what.suite, what.routes),
        seed=what.seed,
        out=what.out.resolve(),
        best=what.best,
        jobs=what.jobs,
        drives=DriveSpec(driver=what.driver, ladder=what.ladder, maps=what.maps, limit_s=what.limit_s),
        search=SearchSettings(beam=what.beam),
    )
    collect(spec, lambda line: print(line, file=sys.stderr, flush=True))
    return write_report(spec.out)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="python -m lab.language.plan_search.collect_command", description=__doc__)
    add_options(parser)
    print(teach(parse_options(parser.parse_args())))


if __name__ == "__main__":
    main()
