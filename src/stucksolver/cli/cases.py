"""`stucksolver cases`: the paper's three cases, acted out and drawn."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from stucksolver.cli.arguments import above_zero, at_least
from stucksolver.cli.errors import UsageError
from stucksolver.cli.words import tell_notes
from stucksolver.ladder import LadderError
from stucksolver.reason import Reasoner
from stucksolver.reason.llm.exchanges import ExchangesError
from stucksolver.reason.make import HELP, ReasonerNameError, make_reasoner, preflight, unanswered_banner

FIGURE = "cases.png"
ABOUT = "act out the paper's three cases with a reasoner, and draw what it saw and decided"


def add_cases(commands: Any) -> argparse.ArgumentParser:
    """Register the command."""
    parser: argparse.ArgumentParser = commands.add_parser("cases", help=ABOUT, description=ABOUT)
    parser.add_argument("--reasoner", default="rules", help=f"{HELP}")
    parser.add_argument("--clock", default="lockstep", help="lockstep, latency:SECONDS or latency:measured")
    parser.add_argument("--map", default="grid_town", help="a town's name or an OpenDRIVE file")
    parser.add_argument("--maps", help="folders to search for towns, separated by ':'")
    parser.add_argument("--out", type=Path, default=Path("out/cases"), help="folder for results")
    parser.add_argument("--deadline", type=above_zero, default=30.0, metavar="S", help="seconds for an answer")
    parser.add_argument(
        "--tries",
        type=at_least(1),
        default=20,
        metavar="N",
        help="answers in a row that may lead nowhere",
    )
    parser.add_argument("--exchanges", action="store_true", help="keep every request and answer in OUT/exchanges")
    return parser


def run_cases_command(options: argparse.Namespace) -> int:
    """0 when each case got a decision, and most questions an answer; 1 otherwise. Raises `UsageError`."""
    from stucksolver.evaluate.cases import CASES, run_cases
    from stucksolver.evaluate.cases.figure import draw_figure
    from stucksolver.evaluate.server import ServerError
    from stucksolver.evaluate.sites import SiteError
    from stucksolver.evaluate.situation import SituationError

    exchanges = options.out / "exchanges" if options.exchanges else None

    def reasoner() -> Reasoner:
        return make_reasoner(options.reasoner, exchanges)

    try:
        tell_notes(preflight(reasoner(), options.reasoner))
        options.out.mkdir(parents=True, exist_ok=True)
        results = run_cases(
            CASES,
            reasoner,
            map_name=options.map,
            maps=options.maps,
            clock=options.clock,
            deadline_s=options.deadline,
            tries=options.tries,
            say=_say,
        )
        draw_figure(results, options.out / FIGURE)
        for result in results:
            events = [event.model_dump(mode="json", exclude_none=True) for event in result.events]
            (options.out / f"{result.case.name}.json").write_text(json.dumps(events, indent=1), encoding="utf-8")
    except (
        ReasonerNameError,
        ExchangesError,
        LadderError,
        SituationError,
        SiteError,
        ServerError,
        ValueError,
    ) as error:
        raise UsageError(str(error)) from error
    except OSError as error:
        raise UsageError(f"{options.out} cannot be written: {error.strerror}") from error
    print(f"figure: {options.out / FIGURE}")
    asked, failed = sum(r.questions for r in results), sum(r.unanswered for r in results)
    warning = unanswered_banner(asked, failed, options.reasoner)
    if warning:
        print(warning, file=sys.stderr)
    return 1 if warning or any(result.decided is None for result in results) else 0


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
