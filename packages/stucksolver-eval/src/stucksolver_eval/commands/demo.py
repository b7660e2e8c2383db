"""`stucksolver demo`: drives the demonstration and writes its report."""

from __future__ import annotations

import argparse
import contextlib
import sys
from dataclasses import replace
from pathlib import Path

from stucksolver.commands.arguments import (
    add_clock,
    add_json,
    add_map,
    add_perception,
    add_server,
    at_least,
    print_json,
    whole,
)
from stucksolver.commands.errors import UsageError
from stucksolver.interpreter import NoInterpreter, find_reader
from stucksolver.reasoners.factory import HELP
from stucksolver.scene import MAX_WORDS
from stucksolver_eval.commands.ride import add_page, page_server, print_page_url
from stucksolver_eval.commands.run_arguments import clock_name, driver_name
from stucksolver_language.commands.api_keys import add_send_key
from stucksolver_passenger.commands.memory import add_memory


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add_map(parser, "demo_town")
    parser.add_argument("--seed", type=whole, default=1, help="seed of positions and traffic")
    parser.add_argument("--recovery", default="search", help=f"the reasoner (default: search): {HELP}")
    add_send_key(parser)
    parser.add_argument(
        "--driver",
        default="behavior",
        help="behavior or planner, each with :cautious|normal|aggressive, or your own driver as MODULE:CLASS",
    )
    parser.add_argument("--road", choices=("any", "one_lane", "multi_lane"), default="any", help="kind of street")
    parser.add_argument(
        "--oncoming",
        type=at_least(0),
        default=3,
        metavar="N",
        help="number of oncoming cars in the street with one lane each way",
    )
    add_clock(parser)
    add_perception(parser)
    parser.add_argument(
        "--say", metavar="WORDS", help="utterance of a passenger in both streets, instead of the built-in script"
    )
    parser.add_argument(
        "--no-pictures", action="store_true", help="store no camera pictures with the decisions (faster)"
    )
    parser.add_argument("--out", type=Path, default=Path("out/demo"), help="folder for results")
    parser.add_argument(
        "--passenger", action="store_true", help="drive in real time, with a page for conversation with the car"
    )
    add_page(parser)
    add_memory(parser)
    add_server(parser)
    add_json(
        parser,
        '{"runs": [{"scenario", "arm", "seed", "result": {"status", "route_completion_pct", "infractions", '
        '"stopped_s", "time_to_recover_s", "immobilizations", "recoveries", "decisions", "plans_accepted", '
        '"duration_s", "distance_m"}}], "report": path}',
    )


def run(options: argparse.Namespace) -> int:
    """Run the demonstration, and print its table and the path of its report. Raises `UsageError`."""
    # The imports are late because they need CARLA's client package, and the help does not.
    from stucksolver.atomic_files import OutputError
    from stucksolver_carla.client_connection import ServerError
    from stucksolver_eval.demo import VEHICLE, DemoSpec, demo
    from stucksolver_eval.report import ReportError
    from stucksolver_eval.run_table import conversation, runs_table
    from stucksolver_eval.runner.isolated_process import RunError
    from stucksolver_eval.streets.finder import StreetError
    from stucksolver_eval.systems.factory import SystemSpecError

    spec = DemoSpec(
        map_name=options.map,
        maps=options.maps,
        seed=options.seed,
        driver=driver_name(options.driver),
        recovery=options.recovery,
        road=options.road,
        oncoming=options.oncoming,
        clock=clock_name(options.clock),
        out=options.out,
        host=options.host,
        port=options.port,
        say=_words(options.say),
        pictures=not options.no_pictures,
        perception=options.perception,
        memory=options.memory,
    )
    try:
        with contextlib.ExitStack() as page:
            if options.passenger:
                server = page.enter_context(page_server(options))
                print_page_url(server, VEHICLE, options.listen, sys.stderr if options.json else sys.stdout)
                spec = replace(spec, passenger=server.address)
            runs, report = demo(spec, _say)
    except (SystemSpecError, RunError, StreetError, ServerError, OutputError, ReportError) as error:
        _end_line()
        raise UsageError(str(error)) from error
    if options.json:
        done = [run.model_dump(mode="json", include={"scenario", "arm", "seed", "result"}) for run in runs]
        print_json({"runs": done, "report": report})
        return 0
    print(runs_table(runs))
    if options.say is not None:
        print("\n" + "\n\n".join(conversation(run) for run in runs))
    print(f"\nreport: {report}")
    return 0


def _words(text: str | None) -> str | None:
    """Check that the interpreter can process the utterance. Raises `UsageError`."""
    if text is None:
        return None
    if not text.strip():
        raise UsageError('--say is empty: give a sentence, as in --say "please go round it"')
    if len(text) > MAX_WORDS:
        raise UsageError(f"--say too long: {len(text)} characters, at most {MAX_WORDS}. Shorten it")
    reader = find_reader()
    if isinstance(reader, NoInterpreter):
        raise UsageError(reader.why)
    return text


_written = 0


def _say(text: str) -> None:
    """Print progress in place on a terminal. Print only complete lines elsewhere."""
    global _written
    if not sys.stderr.isatty():
        if text.endswith("\n"):
            print(text, end="", file=sys.stderr, flush=True)
        return
    print("\r" + text.ljust(_written), end="", file=sys.stderr, flush=True)
    _written = 0 if text.endswith("\n") else len(text)


def _end_line() -> None:
    if sys.stderr.isatty() and _written:
        print(file=sys.stderr)
