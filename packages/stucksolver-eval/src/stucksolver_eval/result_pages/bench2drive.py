"""Tables of the runs of `results/bench2drive.sh`, by three commands.

```sh
python -m stucksolver_eval.result_pages.bench2drive table OUT     # print the table of one folder: all systems and seeds
python -m stucksolver_eval.result_pages.bench2drive keep OUT NAME --commit C --agents A [--note N]
                                                    # store the runs in results/bench2drive/NAME.json
python -m stucksolver_eval.result_pages.bench2drive page > results/bench2drive.md
                                                    # print the page: all stored runs side by side
```

They read the checkpoint files of Bench2Drive's evaluator. For several seeds, a cell contains the mean, and the range if
they differ.
"""

from __future__ import annotations

import argparse
import json
import re
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from statistics import mean
from typing import NamedTuple

from stucksolver_eval.result_pages import RESULTS

STORED = RESULTS / "bench2drive"
ARMS = ("alone", "blind", "timers", "rules", "search", "guided", "sensors-alone", "sensors-rules", "sensors-search")
OUTCOMES = {"Agent crashed": "crashed", "TickRuntime": "stood", "Agent timed out": "slow", "Agent got blocked": "stood"}
"""Short names of the reasons for which a route failed. The evaluator ends a route after 4,000 ticks, or 200 s."""


class Run(NamedTuple):
    """One run of one route. Scores are 0 to 100; times are in seconds."""

    arm: str
    seed: int
    route: str
    scenario: str
    town: str
    status: str
    score: float
    done_percent: float
    game_s: float
    wall_s: float


class StoredRuns(NamedTuple):
    """The stored runs of one commit, with the version of `agents` and a note."""

    name: str
    commit: str
    agents: str
    note: str
    runs: tuple[Run, ...]


def read(out: Path) -> list[Run]:
    """Return all runs in a folder."""
    found = []
    for file in sorted(out.glob("*-*/records/*.json")):
        arm, _, seed = file.parent.parent.name.rpartition("-")
        for record in json.loads(file.read_text(encoding="utf-8"))["_checkpoint"]["records"]:
            named = re.search(r"_rep\d+_(Town\w+?)_", record["save_name"] + "_")
            found.append(
                Run(
                    arm,
                    int(seed),
                    file.stem,
                    record["scenario_name"].rpartition("_")[0] or record["scenario_name"],
                    named.group(1) if named else "?",
                    record["status"],
                    round(float(record["scores"]["score_composed"]), 2),
                    round(float(record["scores"]["score_route"]), 2),
                    round(float(record["meta"]["duration_game"]), 2),
                    round(float(record["meta"]["duration_system"]), 1),
                )
            )
    return found


def keep(out: Path, name: str, commit: str, agents: str, note: str) -> Path:
    """Store the runs of a folder, one per line, without wall times, which depend on the machine. Returns the file."""
    head = {"commit": commit, "agents": agents, "note": note}
    rows = [json.dumps(run._replace(wall_s=0.0)) for run in read(out)]
    path = STORED / f"{name}.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(head)[:-1] + ', "runs": [\n' + ",\n".join(rows) + "\n]}\n", encoding="utf-8")
    return path


def stored_runs() -> list[StoredRuns]:
    """Return all stored runs, sorted by name."""
    found = []
    for path in sorted(STORED.glob("*.json")):
        data = json.loads(path.read_text(encoding="utf-8"))
        runs = tuple(Run(*row) for row in data["runs"])
        found.append(StoredRuns(path.stem, data["commit"], data["agents"], data["note"], runs))
    return found


Columns = dict[str, dict[str, list[Run]]]
"""Runs by column and route."""


def table(columns: Columns, *, wall: bool = False) -> str:
    """Return a Markdown table: a row for each route, then means over the routes that all columns share."""
    routes = sorted({route for runs in columns.values() for route in runs})
    lines = ["| route | scenario | " + " | ".join(columns) + " |", "|---" * (len(columns) + 2) + "|"]
    for route in routes:
        first = next(runs[route][0] for runs in columns.values() if runs.get(route))
        cells = [_cell(runs.get(route, [])) for runs in columns.values()]
        lines.append(f"| {route} {first.town} | {first.scenario} | " + " | ".join(cells) + " |")
    shared = [route for route in routes if all(runs.get(route) for runs in columns.values())]
    rows = [("driving score", _score), ("success, %", _success), ("crashed, %", _crashed)]
    for name, value in [*rows, *([("wall time of a route, s", _wall)] if wall else [])]:
        cells = [f"{value([runs[route] for route in shared]):.1f}" for runs in columns.values()]
        lines.append(f"| **{name}** | {len(shared)} routes | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def by_arm(runs: Iterable[Run]) -> Columns:
    """Group runs into a column for each system, in the order of `ARMS`."""
    found: Columns = defaultdict(lambda: defaultdict(list))
    for run in sorted(runs, key=lambda run: (ARMS.index(run.arm), run.route, run.seed)):
        found[run.arm][run.route].append(run)
    return found


def page(tables: list[StoredRuns]) -> str:
    """Return the page with all stored runs side by side: grouped by system, with one column per stored file."""
    columns: Columns = {}
    for arm in ARMS:
        for item in tables:
            runs = by_arm(item.runs).get(arm)
            if runs:
                columns[f"{arm}, {item.name}"] = runs
    about = "".join(f"| {t.name} | {t.commit} | {t.agents} | {t.note} |\n" for t in tables)
    head = (STORED / "head.md").read_text(encoding="utf-8")
    earlier = (STORED / "earlier.md").read_text(encoding="utf-8")
    return f"{head}\n| table | commit | copy of `agents` | |\n|---|---|---|---|\n{about}\n{table(columns)}\n{earlier}"


def _cell(runs: list[Run]) -> str:
    scores = [run.score for run in runs]
    if not scores:
        return "–"
    spread = "" if max(scores) - min(scores) < 0.05 else f" ({min(scores):.1f} to {max(scores):.1f})"
    ends = sorted({_outcome(run) for run in runs} - {""})
    return f"{mean(scores):.1f}{spread}" + (f" {', '.join(ends)}" if ends else "")


def _outcome(run: Run) -> str:
    reason = run.status.partition(" - ")[2]
    return f"{OUTCOMES.get(reason, reason.lower())} at {run.done_percent:.0f} %" if reason else ""


def _score(routes: list[list[Run]]) -> float:
    return mean(mean(run.score for run in runs) for runs in routes)


def _success(routes: list[list[Run]]) -> float:
    """Return Bench2Drive's success rate (%): completed without infractions other than those for slowness."""
    return 100.0 * mean(mean(run.score > 99.99 for run in runs) for runs in routes)


def _crashed(routes: list[list[Run]]) -> float:
    return 100.0 * mean(mean("crashed" in run.status for run in runs) for runs in routes)


def _wall(routes: list[list[Run]]) -> float:
    return mean(run.wall_s for runs in routes for run in runs)


def main() -> None:
    """Run one of the commands in the module's docstring."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("table").add_argument("out", type=Path)
    keeping = commands.add_parser("keep")
    keeping.add_argument("out", type=Path)
    keeping.add_argument("name")
    for option in ("--commit", "--agents"):
        keeping.add_argument(option, required=True)
    keeping.add_argument("--note", default="")
    commands.add_parser("page")
    arguments = parser.parse_args()
    if arguments.command == "table":
        print(table(by_arm(read(arguments.out)), wall=True), end="")
    elif arguments.command == "keep":
        print(keep(arguments.out, arguments.name, arguments.commit, arguments.agents, arguments.note).name)
    else:
        print(page(stored_runs()), end="")


if __name__ == "__main__":
    main()
