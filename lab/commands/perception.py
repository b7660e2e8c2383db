"""`python -m lab perception`: records drives, trains perception on them, and scores it."""

from __future__ import annotations

import argparse
import sys
from importlib.util import find_spec
from pathlib import Path

from stucksolver.commands.arguments import above_zero, add_json, add_maps, add_server, at_least, print_json, whole
from stucksolver.commands.errors import UsageError
from stucksolver.commands.subcommands import parts_of, run_part
from stucksolver_eval.commands.run_arguments import driver_name

SCORED = ("lidar", "noise", "tracking", "localisation", "lights", "attributes", "far")
TRAINED = ("lidar", "crops", "far")
NEEDS_CLIENT = "not installed: carla, which collecting requires. Add the extra [carla] (README, Install)"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parts_of(parser)
    _add_collect(add("collect", "drive routes and record sensor data with ground truth", _collect))
    _add_eval(add("eval", "run perception on recordings and score it", _eval))
    _add_train(add("train", "train the networks on recordings", _train))
    _add_export(add("export", "install trained networks in the folder that perception reads", _export))


def run(options: argparse.Namespace) -> int:
    """Run the requested subcommand and return its exit code.

    Raises:
        UsageError: The options cannot be used.
    """
    return run_part(options)


def _add_collect(parser: argparse.ArgumentParser) -> None:
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--suite", default="", help="bench220, dev, immobilized, or a leaderboard route file")
    where.add_argument(
        "--towns", default="", metavar="TOWN,TOWN", help="random drives in these towns, in dense mixed traffic"
    )
    parser.add_argument("--routes", default="", metavar="ID,ID", help="only these routes of the suite")
    parser.add_argument("--drives", type=at_least(1), default=1, help="number of random drives in each town")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder for recordings; drives already there remain"
    )
    parser.add_argument("--jobs", type=at_least(1), default=2, help="number of routes driven in parallel")
    parser.add_argument("--seed", type=whole, default=1, help="seed of traffic, weather, pedestrians and random routes")
    parser.add_argument(
        "--limit-s", type=above_zero, default=60.0, metavar="S", help="longest simulated time of a drive"
    )
    parser.add_argument("--driver", default="behavior", help="behavior or planner, each with :PROFILE")
    parser.add_argument(
        "--weather", choices=("random", "route"), default="random", help="random weather, or that of the route file"
    )
    parser.add_argument(
        "--every",
        type=float,
        default=1.0,
        metavar="S",
        help="interval between the stored windows of ticks; 0 stores all",
    )
    add_maps(parser)
    add_server(parser)
    add_json(parser, '{"recordings": number of drives in DIR, "failed": [a line for each failed route]}')


def _add_eval(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--data", type=Path, required=True, metavar="DIR", help="recordings that were not used for training"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for scores")
    parser.add_argument("--only", default="", metavar="PART,PART", help=f"some of {', '.join(SCORED)}")
    parser.add_argument("--lidar-weights", type=Path, metavar="DIR", help="weights to use instead of the shipped ones")
    parser.add_argument("--camera-weights", type=Path, metavar="DIR", help="weights to use instead of the shipped ones")
    parser.add_argument("--threads", type=at_least(1), default=1, help="number of threads for each network")
    add_json(parser, 'the scores, as written to DIR/perception.json: {"parts": {name: figures}, "left_out", ...}')


def _add_train(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--data", type=Path, nargs="+", required=True, metavar="DIR", help="recordings to learn from")
    parser.add_argument("--check", type=Path, nargs="+", required=True, metavar="DIR", help="recordings to validate on")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="output, with a folder for each network")
    parser.add_argument("--only", default="", metavar="NAME,NAME", help=f"some of {', '.join(TRAINED)}")
    parser.add_argument("--minutes", type=above_zero, default=8.0, help="training time for each network")
    parser.add_argument("--seed", type=whole, default=1, help="seed of the training")


def _add_export(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--run", dest="run_folder", type=Path, required=True, metavar="DIR", help="output of `perception train`"
    )
    parser.add_argument("--check", type=Path, nargs="+", required=True, metavar="DIR", help="recordings to validate on")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder to use instead of the one that perception reads"
    )
    parser.add_argument("--only", default="", metavar="NAME,NAME", help=f"some of {', '.join(TRAINED)}")
    add_json(parser, '{"folders": [a path for each folder that was written]}')


def _collect(options: argparse.Namespace) -> int:
    if find_spec("carla") is None:
        raise UsageError(NEEDS_CLIENT)
    from lab.perception.recording.collect_recordings import CollectSpec, collect
    from lab.perception.recording.town_routes import TownError
    from stucksolver.atomic_files import OutputError
    from stucksolver_carla.client_connection import ServerError
    from stucksolver_eval.routes import RouteFileError
    from stucksolver_eval.suites import SuiteError
    from stucksolver_eval.systems.factory import SystemSpecError

    if options.every and not 0.6 <= options.every <= 60.0:
        raise UsageError(f"--every: expected 0, or 0.6 to 60 seconds, got {options.every:g}")
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
    except (SystemSpecError, OutputError, TownError, RouteFileError, ServerError, SuiteError) as error:
        raise UsageError(str(error)) from error
    if options.json:
        print_json({"recordings": found.done, "failed": found.failed})
        return 1 if found.failed else 0
    print(f"{found.done} recordings in {options.out}; {len(found.failed)} routes failed")
    for line in found.failed:
        print(f"  {line}")
    return 1 if found.failed else 0


def _eval(options: argparse.Namespace) -> int:
    from lab.perception.evaluation.scoring.evaluate import evaluate_perception
    from lab.perception.evaluation.scoring.scoring_part import ScoringInput
    from stucksolver.atomic_files import OutputError
    from stucksolver_perception.recording import RecordingError

    only = _some(options.only, SCORED)
    scoring_input = ScoringInput((), options.lidar_weights, options.camera_weights, options.threads)
    try:
        found = evaluate_perception(options.data, options.out, only, scoring_input)
    except (RecordingError, OutputError) as error:
        raise UsageError(str(error)) from error
    for part, reason in found.left_out.items():
        print(f"note: {part} was left out: {reason}", file=sys.stderr)
    print(found.scores.read_text(encoding="utf-8").rstrip("\n") if options.json else found.page)
    return 0 if found.done else 1


def _train(options: argparse.Namespace) -> int:
    from lab.perception.training.train_networks import TrainingError, TrainSpec, train_networks

    spec = (tuple(options.data), tuple(options.check), options.out)
    try:
        train_networks(TrainSpec(*spec, _some(options.only, TRAINED), options.minutes, options.seed))
    except TrainingError as error:
        raise UsageError(str(error)) from error
    return 0


def _export(options: argparse.Namespace) -> int:
    from lab.perception.training.train_networks import TrainingError, export_networks
    from stucksolver.atomic_files import OutputError

    only = _some(options.only, TRAINED)
    try:
        found = export_networks(options.run_folder, options.check, options.out, only)
    except (TrainingError, OutputError) as error:
        raise UsageError(str(error)) from error
    folders = list(dict.fromkeys(found))
    if options.json:
        print_json({"folders": folders})
    else:
        print("\n".join(map(str, folders)))
    return 0


def _some(text: str, known: tuple[str, ...]) -> tuple[str, ...]:
    """Split a list of names, each of which must be known.

    Raises:
        UsageError: A name is unknown.
    """
    names = _names(text)
    strange = [name for name in names if name not in known]
    if strange:
        raise UsageError(f"--only: expected some of {', '.join(known)}, got {strange[0]!r}")
    return names


def _names(text: str) -> tuple[str, ...]:
    return tuple(filter(None, text.split(",")))
