"""Copies the summaries of evaluations into `results`.

```sh
python -m stucksolver_eval.result_pages.archive_results OUT/latency latency
```

It copies only small and repeatable files: `summary.json` and `routes.csv` of each system, without wall times and paths.
It adds one entry, `plans`: the number of plans that moved the vehicle, and the events from their start to 10 s after
their end, and on the whole routes. `python -m stucksolver_eval.result_pages.result_tables latency` prints the tables.
"""

from __future__ import annotations

import csv
import io
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from stucksolver_eval.metrics.recovery import AFTER_S
from stucksolver_eval.metrics.right_reaction import NOT_HARM
from stucksolver_eval.result_pages import RESULTS

WALL = ("wall_s",)
KINDS = ("collisions", "others", "near")


def keep(out: Path, name: str) -> list[str]:
    """Copy the summaries of all systems in `out` to `results/NAME`. Returns the names of the systems."""
    done = []
    for summary in sorted(out.glob("*/summary.json")):
        arm = summary.parent.name
        folder = RESULTS / name / arm
        folder.mkdir(parents=True, exist_ok=True)
        data = json.loads(summary.read_text(encoding="utf-8"))
        data["manifest"]["command"] = re.sub(r"(--\w+) /\S+", r"\1 …", data["manifest"]["command"])
        data["recovery"].pop("latencies_s", None)
        data["plans"] = _plans(summary.parent)
        (folder / "summary.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
        (folder / "routes.csv").write_text(_routes(summary.with_name("routes.csv")), encoding="utf-8")
        done.append(arm)
    return done


def _plans(arm: Path) -> dict[str, int]:
    """Count collisions, other infractions and near misses: during plans that move, during waits, and on whole routes.

    Another vehicle may also hit a waiting vehicle. For comparison, the events of the driver alone in the same time
    spans are counted, if they exist.
    """
    alone = arm.parent / f"{arm.name.split('-')[0]}-alone"
    wheres = ("", "_route", "_waits", "_waits_alone")
    found = {"moved": 0} | {f"{what}{where}": 0 for what in KINDS for where in wheres}
    for path in sorted(arm.glob("seed-*/outcomes/*.json")):
        outcome = json.loads(path.read_text(encoding="utf-8"))
        moves, waits = (
            [item for item in outcome["interventions"] if item["moves"] is is_move] for is_move in (True, False)
        )
        found["moved"] += len(moves)
        for what, time_s in _events(outcome):
            found[f"{what}_route"] += 1
            found[what] += _is_within(time_s, moves)
            found[f"{what}_waits"] += _is_within(time_s, waits)
        paired = alone / path.relative_to(arm)
        if paired.is_file():
            for what, time_s in _events(json.loads(paired.read_text(encoding="utf-8"))):
                found[f"{what}_waits_alone"] += _is_within(time_s, waits)
    return found


def _events(outcome: dict[str, Any]) -> Iterator[tuple[str, float]]:
    for item in outcome["near_misses"]:
        yield "near", item["time_s"]
    for item in outcome["infractions"]:
        if item["kind"] not in NOT_HARM:
            yield "collisions" if item["kind"].startswith("collision") else "others", item["time_s"]


def _is_within(time_s: float, plans: list[dict[str, Any]]) -> bool:
    return any(plan["start_s"] <= time_s <= plan["end_s"] + AFTER_S for plan in plans)


def _routes(path: Path) -> str:
    rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))
    fields = [name for name in rows[0] if name not in WALL]
    text = io.StringIO()
    writer = csv.DictWriter(text, fields, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


if __name__ == "__main__":
    print(", ".join(keep(Path(sys.argv[1]), sys.argv[2])))
