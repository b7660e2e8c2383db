"""The table of `results/bench2drive.sh`: `python results/bench2drive.py OUT > table.md`.

Reads the checkpoint files that Bench2Drive's evaluator wrote. Of several seeds the mean stands, and the range where
they differ.
"""

from __future__ import annotations

import json
import re
import sys
from collections import defaultdict
from pathlib import Path
from statistics import mean
from typing import NamedTuple

ARMS = ("alone", "blind", "timers", "rules", "guided")


class Run(NamedTuple):
    """One route, driven once."""

    scenario: str
    town: str
    status: str
    score: float
    game_s: float
    wall_s: float


Runs = dict[str, dict[str, list[Run]]]
"""By arm and route."""


def read(out: Path) -> Runs:
    """All that is there."""
    found: Runs = defaultdict(lambda: defaultdict(list))
    for file in sorted(out.glob("*-*/records/*.json")):
        arm = file.parent.parent.name.rpartition("-")[0]
        for record in json.loads(file.read_text(encoding="utf-8"))["_checkpoint"]["records"]:
            named = re.search(r"_rep\d+_(Town\w+?)_", record["save_name"] + "_")
            found[arm][file.stem].append(
                Run(
                    record["scenario_name"].rpartition("_")[0] or record["scenario_name"],
                    named.group(1) if named else "?",
                    record["status"],
                    float(record["scores"]["score_composed"]),
                    float(record["meta"]["duration_game"]),
                    float(record["meta"]["duration_system"]),
                )
            )
    return found


def table(runs: Runs) -> str:
    """Markdown: a row for each route, then means."""
    arms = [arm for arm in ARMS if arm in runs]
    routes = sorted({route for arm in arms for route in runs[arm]})
    lines = ["| route | scenario | " + " | ".join(arms) + " |", "|---" * (len(arms) + 2) + "|"]
    for route in routes:
        first = next(runs[arm][route][0] for arm in arms if runs[arm].get(route))
        cells = [_cell(runs[arm].get(route, [])) for arm in arms]
        lines.append(f"| {route} {first.town} | {first.scenario} | " + " | ".join(cells) + " |")
    for name, value in (("driving score", _score), ("success, %", _success), ("wall time of a route, s", _wall)):
        lines.append(f"| **{name}** | | " + " | ".join(f"{value(runs[arm]):.1f}" for arm in arms) + " |")
    return "\n".join(lines) + "\n"


def _cell(runs: list[Run]) -> str:
    scores = [run.score for run in runs]
    if not scores:
        return "–"
    spread = "" if max(scores) - min(scores) < 0.05 else f" ({min(scores):.1f} to {max(scores):.1f})"
    return f"{mean(scores):.1f}{spread}"


def _score(routes: dict[str, list[Run]]) -> float:
    return mean(mean(run.score for run in runs) for runs in routes.values())


def _success(routes: dict[str, list[Run]]) -> float:
    """As Bench2Drive counts it: to the end, and without an infraction but that for slowness, which costs no points."""
    return 100.0 * mean(mean(run.score > 99.99 for run in runs) for runs in routes.values())


def _wall(routes: dict[str, list[Run]]) -> float:
    return mean(run.wall_s for runs in routes.values() for run in runs)


if __name__ == "__main__":
    print(table(read(Path(sys.argv[1]))), end="")
