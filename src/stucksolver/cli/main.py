"""`stucksolver`: the commands."""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from stucksolver.cli.arguments import Parser, at_least, installed_version, port, whole
from stucksolver.cli.cases import add_cases, run_cases_command
from stucksolver.cli.doctor import SUPPORTED, add_doctor, run_doctor
from stucksolver.cli.errors import UsageError
from stucksolver.cli.evaluate import add_evaluate, run_evaluate
from stucksolver.cli.ladder import add_ladder, run_ladder
from stucksolver.cli.prompt import add_prompt, run_prompt
from stucksolver.cli.read_words import add_words, run_words
from stucksolver.cli.replay import add_replay, run_replay
from stucksolver.cli.score import add_compare, add_score, run_compare, run_score
from stucksolver.cli.watch import add_watch, run_watch

PIPE_CLOSED = 128 + 13
"""As a shell has it for a program that ends by SIGPIPE."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of the `stucksolver` command; returns the exit code."""
    options = _parser().parse_args(arguments)
    try:
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        print("\ninterrupted", file=sys.stderr)
        return 130
    except UsageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # Whoever read the output has had enough. Python would complain once more while it closes the stream.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED


def _parser() -> argparse.ArgumentParser:
    parser = Parser(prog="stucksolver", description="Gets immobilized vehicles moving again.")
    parser.add_argument("--version", action="version", version=f"%(prog)s {installed_version()}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    about = "drive past a parked car and two cyclists, without and with help, and report"
    demo = commands.add_parser("demo", help=about, description=about)
    demo.add_argument("--map", default="demo_town", help="a town's name or an OpenDRIVE file")
    demo.add_argument("--maps", help="folders to search for towns, separated by ':'")
    demo.add_argument("--seed", type=whole, default=1, help="of places and traffic")
    demo.add_argument(
        "--driver",
        default="behavior",
        help="behavior, or behavior:cautious, behavior:normal, behavior:aggressive",
    )
    demo.add_argument("--road", choices=("any", "one_lane", "multi_lane"), default="any", help="kind of street")
    demo.add_argument(
        "--oncoming",
        type=at_least(0),
        default=3,
        metavar="N",
        help="cars that come towards us where there is one lane each way",
    )
    demo.add_argument("--clock", default="lockstep", help="lockstep, latency:SECONDS or latency:measured")
    demo.add_argument("--say", metavar="WORDS", help="what a passenger says in both streets, instead of our own script")
    demo.add_argument("--out", type=Path, default=Path("out/demo"), help="folder for results")
    demo.add_argument("--host", help="use the CARLA server at this address instead of starting carlette")
    demo.add_argument("--port", type=port, default=2000, help="of that server")
    demo.set_defaults(run=_demo)
    add_evaluate(commands).set_defaults(run=_evaluate)
    add_score(commands).set_defaults(run=run_score)
    add_compare(commands).set_defaults(run=run_compare)
    add_watch(commands).set_defaults(run=_watch)
    add_replay(commands).set_defaults(run=run_replay)
    add_ladder(commands).set_defaults(run=run_ladder)
    add_prompt(commands).set_defaults(run=run_prompt)
    add_words(commands).set_defaults(run=run_words)
    add_cases(commands).set_defaults(run=_cases)
    add_doctor(commands).set_defaults(run=run_doctor)
    return parser


def _demo(options: argparse.Namespace) -> int:
    _require_client()
    from stucksolver.cli.demo import run_demo

    return run_demo(options)


def _evaluate(options: argparse.Namespace) -> int:
    _require_client()
    return run_evaluate(options)


def _cases(options: argparse.Namespace) -> int:
    _require_client()
    return run_cases_command(options)


def _watch(options: argparse.Namespace) -> int:
    _require_client()
    return run_watch(options)


def _require_client() -> None:
    if importlib.util.find_spec("carla") is None:
        raise UsageError(
            f"the carla package is not installed; it exists for {SUPPORTED}: pip install 'stucksolver[sim]'"
        )
