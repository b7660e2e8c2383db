"""`stucksolver cases`: runs the cases of Bao and Li 2025 (arXiv:2510.26023), and draws a figure of each."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from stucksolver.commands.arguments import above_zero, add_clock, add_json, add_map, at_least, print_json
from stucksolver.commands.errors import UsageError
from stucksolver.commands.json_lines import json_lines
from stucksolver.ladder import LadderError
from stucksolver.reasoners.factory import HELP, make_reasoner, preflight, sees, unanswered_banner
from stucksolver.reasoners.registry import ReasonerNameError
from stucksolver_eval.commands.run_arguments import print_notes
from stucksolver_language.commands.api_keys import add_send_key

if TYPE_CHECKING:
    from stucksolver_eval.cases import CaseResult
    from stucksolver_eval.cases.wordings import Wording

FIGURE, WORDINGS = "cases.png", "wordings.png"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("--reasoner", default="search", help=f"{HELP}")
    add_send_key(parser)
    add_clock(parser)
    add_map(parser, "grid_town")
    parser.add_argument("--out", type=Path, default=Path("out/cases"), help="folder for results")
    parser.add_argument(
        "--deadline", type=above_zero, default=30.0, metavar="S", help="time limit for an answer, in seconds"
    )
    parser.add_argument(
        "--tries",
        type=at_least(1),
        default=20,
        metavar="N",
        help="end after this many failed attempts in a row",
    )
    parser.add_argument(
        "--wordings",
        type=Path,
        metavar="FILE",
        help='instead, drive the cyclists\' case once for each sentence in FILE, a JSON line each: {"text": "..."}',
    )
    parser.add_argument(
        "--exchanges",
        action="store_true",
        help="keep records of interventions in OUT, and every request and answer in OUT/exchanges",
    )
    add_json(
        parser,
        '{"cases": [{"name", "decided" (an event or null), "progress_m", "collisions", "questions", "unanswered"}], '
        '"figure": path}',
    )


def run(options: argparse.Namespace) -> int:
    """Run the cases. Returns 1 if a case got no decision or most questions no answer, else 0. Raises `UsageError`."""
    from stucksolver.atomic_files import OutputError
    from stucksolver_carla.client_connection import ServerError
    from stucksolver_eval.cases import CASES, run_cases
    from stucksolver_eval.cases.figure import draw_figure
    from stucksolver_eval.cases.wordings import draw_wordings, worded
    from stucksolver_eval.runner.isolated_process import RunError
    from stucksolver_eval.streets.finder import StreetError

    figure = WORDINGS if options.wordings is not None else FIGURE
    wordings = _wordings(options.wordings) if options.wordings is not None else ()
    try:
        print_notes(preflight(make_reasoner(options.reasoner), options.reasoner))
        options.out.mkdir(parents=True, exist_ok=True)
        results = run_cases(
            worded(wordings) if wordings else CASES,
            options.reasoner,
            options.out,
            map_name=options.map,
            maps=options.maps,
            clock=options.clock,
            deadline_s=options.deadline,
            tries=options.tries,
            pictures=not wordings or sees(options.reasoner),
            record=options.exchanges,
            say=_say,
        )
        if wordings:
            draw_wordings(wordings, results, options.out / figure)
        else:
            draw_figure(results, options.out / figure)
        for result in results:
            events = [event.model_dump(mode="json", exclude_none=True) for event in result.events]
            (options.out / f"{result.case.name}.json").write_text(json.dumps(events, indent=1), encoding="utf-8")
    except (
        ReasonerNameError,
        LadderError,
        OutputError,
        RunError,
        StreetError,
        ServerError,
        ValueError,
    ) as error:
        raise UsageError(str(error)) from error
    except OSError as error:
        raise UsageError(f"cannot write folder: {options.out}: {error.strerror}. Choose another --out") from error
    if options.json:
        print_json({"cases": [_data(result) for result in results], "figure": options.out / figure})
    else:
        print(f"figure: {options.out / figure}")
    asked, failed = sum(r.questions for r in results), sum(r.unanswered for r in results)
    warning = unanswered_banner(asked, failed, options.reasoner)
    if warning:
        print(warning, file=sys.stderr)
    undecided = not wordings and any(result.decided is None for result in results)
    return 1 if warning or undecided else 0


def _data(result: CaseResult) -> dict[str, object]:
    decided = result.decided
    return {
        "name": result.case.name,
        "decided": None if decided is None else decided.model_dump(mode="json", exclude_none=True),
        "progress_m": result.progress_m,
        "collisions": result.collisions,
        "questions": result.questions,
        "unanswered": result.unanswered,
    }


def _wordings(path: Path) -> tuple[Wording, ...]:
    """Read the sentences from a file of JSON lines. Raises `UsageError`."""
    from stucksolver_eval.cases.wordings import Wording

    found = []
    for where, entry in json_lines(path):
        text, meant = entry.get("text"), entry.get("intent")
        if not isinstance(text, str) or not isinstance(meant, str | None):
            raise UsageError(f'{where}: expected {{"text": "..."}}, with "intent": "..." if its meaning is known')
        found.append(Wording(text, meant))
    if not found:
        raise UsageError(f"no sentence in file: {path}. Add one per line")
    return tuple(found)


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
