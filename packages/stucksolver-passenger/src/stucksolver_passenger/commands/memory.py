"""`stucksolver memory`: lists, shows, exports, imports and deletes the entries of a memory file."""

from __future__ import annotations

import argparse
import datetime
import json
import sys
import time
from pathlib import Path

from stucksolver.commands.arguments import above_zero, add_json, at_least, print_json
from stucksolver.commands.errors import UsageError
from stucksolver.commands.subcommands import parts_of, run_part
from stucksolver_passenger.memory import MemoryFileError, SolutionStore, StoredSolution, TriedSolution
from stucksolver_passenger.memory.store import DAY_S

WORDS_SHOWN = 44
"""Longest part of an utterance that `list` prints (characters). Ours."""
STDIN = Path("-")


def add_memory(parser: argparse.ArgumentParser) -> None:
    """Add `--memory`, which all commands with a drive share."""
    parser.add_argument(
        "--memory",
        type=Path,
        metavar="FILE",
        help="store utterances and tried solutions in this file, and propose first what worked; see docs/privacy.md",
    )


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parts_of(parser)
    listed = _with_file(add("list", "print all entries, one line each", _list))
    add_json(listed, 'one object per line, {"number", ...} with the fields of `memory export`')
    shown = _with_file(add("show", "print one entry in full, as JSON", _show))
    shown.add_argument("number", type=at_least(1), metavar="NUMBER", help="number of the entry in `memory list`")
    _with_file(add("export", "print all entries as JSON lines, for `memory import`", _export))
    imported = _with_file(add("import", "add entries that `memory export` printed", _import))
    imported.add_argument("lines", type=Path, metavar="LINES", help="an exported file, or - for standard input")
    add_json(imported, '{"added": number of entries}')
    forgotten = _with_file(add("forget", "delete entries permanently", _forget))
    forgotten.add_argument("numbers", type=at_least(1), nargs="*", metavar="NUMBER", help="numbers of the entries")
    forgotten.add_argument("--days", type=above_zero, metavar="N", help="entries older than this many days")
    forgotten.add_argument("--vehicle", metavar="ID", help="all entries of this vehicle")
    forgotten.add_argument("--all", action="store_true", help="all entries")
    add_json(forgotten, '{"forgotten": number of entries}')


def run(options: argparse.Namespace) -> int:
    """Run the requested subcommand and return its exit code. Raises `UsageError`."""
    return run_part(options, MemoryFileError)


def _with_file(parser: argparse.ArgumentParser) -> argparse.ArgumentParser:
    parser.add_argument("file", type=Path, metavar="FILE", help="the memory file, as given to --memory")
    return parser


def _list(options: argparse.Namespace) -> int:
    solutions = SolutionStore(options.file, create=False).episodes()
    for item in solutions:
        print(json.dumps(_data(item), ensure_ascii=False) if options.json else _line(item))
    if not solutions and not options.json:
        print("the memory is empty")
    return 0


def _show(options: argparse.Namespace) -> int:
    item = SolutionStore(options.file, create=False).episode(options.number)
    if item is None:
        raise UsageError(
            f"no such entry: {options.number}. `stucksolver memory list {options.file}` prints the numbers"
        )
    print(json.dumps(_data(item), indent=2, ensure_ascii=False))
    return 0


def _export(options: argparse.Namespace) -> int:
    for episode in SolutionStore(options.file, create=False).episodes():
        print(episode.episode.model_dump_json(exclude_none=True))
    return 0


def _import(options: argparse.Namespace) -> int:
    try:
        text = sys.stdin.read() if options.lines == STDIN else options.lines.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read file: {options.lines}: {error}. Give a file from `memory export`") from error
    episodes = [_read(options.lines, number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    store = SolutionStore(options.file)
    for episode in episodes:
        store.add(episode)
    if options.json:
        print_json({"added": len(episodes)})
    else:
        print(f"{len(episodes)} added")
    return 0


def _read(file: Path, number: int, line: str) -> TriedSolution:
    try:
        return TriedSolution.model_validate_json(line)
    except ValueError as error:
        raise UsageError(f"not a memory entry: {file}, line {number}. Nothing was added") from error


def _forget(options: argparse.Namespace) -> int:
    asked = options.numbers or options.days is not None or options.vehicle is not None or options.all
    if not asked:
        raise UsageError("nothing selected: give entry numbers, --days, --vehicle or --all")
    store = SolutionStore(options.file, create=False)
    if options.all:
        gone = store.forget_all()
    else:
        before_s = None if options.days is None else time.time() - options.days * DAY_S
        gone = store.forget(numbers=tuple(options.numbers), before_s=before_s, vehicle=options.vehicle)
    if options.json:
        print_json({"forgotten": gone})
    else:
        print(f"{gone} deleted")
    return 0


def _data(solution: StoredSolution) -> dict[str, object]:
    return {"number": solution.number, **solution.episode.model_dump(mode="json", exclude_none=True)}


def _line(solution: StoredSolution) -> str:
    """Return number, time, vehicle, obstacle, utterance, solution and outcome of an entry as one line."""
    episode = solution.episode
    when = datetime.datetime.fromtimestamp(episode.at_s).strftime("%Y-%m-%d %H:%M")
    utterance = "".join(c if c.isprintable() else " " for c in episode.text)
    utterance = (
        f'"{utterance[:WORDS_SHOWN]}{"…" if len(utterance) > WORDS_SHOWN else ""}"' if utterance else "(no guidance)"
    )
    done = "nothing" if episode.solution is None else episode.solution.name
    what = f"{episode.scene.obstacle}, {episode.scene.motion.value}"
    return f"{solution.number:>5}  {when}  {episode.vehicle}  {what}: {utterance} → {done}: {episode.ending.value}"
