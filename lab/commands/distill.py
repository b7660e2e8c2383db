"""`python -m lab distill`: collects training data of the student, trains it, scores it, and exports it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from stucksolver.commands.arguments import above_zero, add_maps, at_least, whole
from stucksolver.commands.errors import UsageError
from stucksolver.commands.subcommands import parts_of

INTERRUPTED = "interrupted: finished parts are stored. Run the same command again to continue"
NEEDS_TORCH = "not installed: torch, onnx. Install them with `pip install torch onnx`"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parts_of(parser)
    _add_collect(add("collect", "drive standstills of a suite, or read records, and store the training data", _collect))
    _add_train(add("train", "train the student on collected data, and score it on the held-out part", _train))
    _add_eval(add("eval", "score the student on collected data", _eval))
    _add_wordings(add("wordings", "score the student's plans after a passenger's sentences", _wordings))
    _add_export(add("export", "check trained weights and copy the files for driving with them", _export))


def run(options: argparse.Namespace) -> int:
    """Run the requested subcommand and return its exit code.

    Raises:
        UsageError: The options cannot be used.
    """
    try:
        return int(options.part(options))
    except KeyboardInterrupt:
        # An interruption is no error: the finished parts are stored.
        print(f"\n{INTERRUPTED}", file=sys.stderr)
        return 130


def _add_collect(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--suite", help="bench220, dev, immobilized, or a leaderboard route file")
    source.add_argument(
        "--records",
        type=Path,
        metavar="DIR",
        help="records of interventions (evaluate --record) instead of drives: the answers of any reasoner or model",
    )
    parser.add_argument(
        "--waits",
        action="store_true",
        help="drive with the driver alone, and store when it went on and which plans the guard accepts, "
        "instead of searching plans",
    )
    parser.add_argument("--routes", default="", metavar="ID,ID", help="only these routes of the suite")
    parser.add_argument("--seed", type=whole, default=1, help="seed of the traffic")
    parser.add_argument(
        "--best", type=at_least(1), default=10, metavar="N", help="plans driven exactly at each standstill"
    )
    parser.add_argument("--jobs", type=at_least(1), default=2, help="number of routes driven in parallel")
    parser.add_argument(
        "--limit", type=above_zero, metavar="S", help="end every route at this time (default with --waits: 120)"
    )
    parser.add_argument("--ladder", type=Path, metavar="FILE", help="escalation policy (default: evaluation)")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder; an existing one continues")
    add_maps(parser)


def _add_train(parser: argparse.ArgumentParser) -> None:
    _add_data(parser)
    parser.add_argument("--minutes", type=above_zero, default=5.0, help="training time")
    parser.add_argument(
        "--steps", type=at_least(1), metavar="N", help="train for this many steps instead: exactly repeatable"
    )
    parser.add_argument("--seed", type=whole, default=1, help="seed of the training")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the weights and scores")


def _add_eval(parser: argparse.ArgumentParser) -> None:
    _add_data(parser)
    parser.add_argument("--weights", type=Path, metavar="DIR", help="folder of the weights (default: those shipped)")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the scores")


def _add_wordings(parser: argparse.ArgumentParser) -> None:
    _add_data(parser)
    parser.add_argument("--weights", type=Path, metavar="DIR", help="folder of the weights (default: those shipped)")
    parser.add_argument(
        "--sentences",
        type=Path,
        nargs="+",
        required=True,
        metavar="FILE",
        help='JSON lines with "text", "situation", "intent" and "side", such as results/words/blind-1.jsonl',
    )


def _add_export(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--weights", type=Path, required=True, metavar="DIR", help="folder that `train` wrote")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder to drive with, as --recovery distilled:DIR"
    )


def _add_data(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--data", type=Path, nargs="+", required=True, metavar="DIR", help="folders that `collect --waits` filled"
    )
    parser.add_argument(
        "--hold-out",
        default="motorway",
        metavar="NAME,NAME",
        help="maps, and routes as SUITE/ID, that are not trained on, only scored",
    )


def _collect(options: argparse.Namespace) -> int:
    if options.records is not None:
        return _from_records(options)
    from lab.language.plan_search.campaign import PlanSearchError
    from lab.language.plan_search.wait_samples import WaitingError
    from stucksolver.atomic_files import OutputError
    from stucksolver_eval.routes import RouteFileError
    from stucksolver_eval.suites import SuiteError

    _require_client()
    try:
        return _waits(options) if options.waits else _plans(options)
    except (PlanSearchError, OutputError, RouteFileError, SuiteError, WaitingError) as error:
        raise UsageError(str(error)) from error


def _require_client() -> None:
    from importlib.util import find_spec

    if find_spec("carla") is None:
        raise UsageError("not installed: carla, which driving requires. Add the extra [carla] (README, Install)")


def _plans(options: argparse.Namespace) -> int:
    from lab.language.plan_search.collect_command import CollectOptions, teach

    report = teach(
        CollectOptions(
            suite=options.suite,
            out=options.out,
            seed=options.seed,
            routes=_names(options.routes),
            best=options.best,
            jobs=options.jobs,
            ladder=options.ladder,
            maps=options.maps,
            limit_s=options.limit,
        )
    )
    print(report)
    return 0


def _waits(options: argparse.Namespace) -> int:
    from lab.language.plan_search.counterfactual_run import DriveSpec
    from lab.language.plan_search.wait_samples import LIMIT_S, WaitingSpec, collect_waits
    from stucksolver_eval.suites import load_routes

    drives = DriveSpec(ladder=options.ladder, maps=options.maps, limit_s=options.limit or LIMIT_S)
    spec = WaitingSpec(
        suite=Path(options.suite).stem,
        routes=load_routes(options.suite, _names(options.routes)),
        seeds=(options.seed,),
        out=options.out.resolve(),
        jobs=options.jobs,
        drives=drives,
    )
    failed = collect_waits(spec, lambda line: print(line, file=sys.stderr, flush=True))
    print(options.out)
    for line in failed:
        print(f"  not driven: {line}")
    return 1 if failed else 0


def _from_records(options: argparse.Namespace) -> int:
    from lab.language.plan_search.record_samples import collect_records
    from stucksolver.atomic_files import OutputError
    from stucksolver.record import RecordError

    try:
        count = collect_records(options.records, options.out)
    except (OutputError, RecordError) as error:
        raise UsageError(str(error)) from error
    print(f"{count} answers in {options.out}")
    return 0 if count else 1


def _train(options: argparse.Namespace) -> int:
    try:
        import onnx  # noqa: F401
        import torch  # noqa: F401
    except ImportError as error:
        raise UsageError(NEEDS_TORCH) from error
    from lab.language.student.commands import StudentJob, train
    from lab.language.student.export import ExportError

    asked = StudentJob(
        data=tuple(options.data),
        out=options.out,
        apart=_names(options.hold_out),
        minutes=options.minutes,
        steps=options.steps,
        seed=options.seed,
    )
    try:
        print(train(asked, lambda line: print(line, flush=True)))
    except (ExportError, OSError, ValueError) as error:
        raise UsageError(str(error)) from error
    return 0


def _eval(options: argparse.Namespace) -> int:
    from lab.language.student.commands import score
    from stucksolver_language.student.network import DATA

    try:
        score(options.data, options.weights or DATA, options.out, _names(options.hold_out), print)
    except (OSError, ValueError) as error:
        raise UsageError(str(error)) from error
    return 0


def _wordings(options: argparse.Namespace) -> int:
    from lab.language.student.guidance_following import places_in, sentences_in, wording_scores, wording_table
    from stucksolver.interpreter import NoInterpreter, find_reader
    from stucksolver_language.student import DistilledReasoner
    from stucksolver_language.student.network import DATA

    reader = find_reader()
    if isinstance(reader, NoInterpreter):
        raise UsageError(reader.why)
    try:
        places = places_in(options.data, _names(options.hold_out))
        student = DistilledReasoner(options.weights or DATA)
        found = wording_scores(sentences_in(options.sentences), places, student, reader)
    except (OSError, ValueError) as error:
        raise UsageError(str(error)) from error
    if not found:
        raise UsageError("no accepted plan of a requested kind at any held-out sample. Use other sentences or data")
    print(wording_table(found))
    return 0


def _export(options: argparse.Namespace) -> int:
    from lab.language.student.commands import copy_to

    try:
        print(copy_to(options.weights, options.out))
    except (OSError, ValueError) as error:
        raise UsageError(str(error)) from error
    return 0


def _names(text: str) -> tuple[str, ...]:
    return tuple(filter(None, text.split(",")))
