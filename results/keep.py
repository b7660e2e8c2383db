"""Copies the summaries of evaluations into a folder of this one: `python results/keep.py OUT/latency latency`.

Only what is small and repeatable: `summary.json` and `routes.csv` of each arm, without wall times and paths. One entry
is added, `plans`: how many plans moved the vehicle, and what happened from their start to 10 s after their end, and on
the whole routes. `python results/tables.py latency` shows what is kept.
"""

from __future__ import annotations

import csv
import io
import json
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
WALL = ("wall_s",)
AFTER_S = 10.0
"""So long after its end a plan is held answerable."""
NO_HARM = {"min_speed_infractions", "vehicle_blocked", "route_timeout", "scenario_timeouts"}


def keep(out: Path, name: str) -> list[str]:
    """The arms that were copied."""
    done = []
    for summary in sorted(out.glob("*/summary.json")):
        arm = summary.parent.name
        folder = HERE / name / arm
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
    found = {"moved": 0} | {
        f"{what}{where}": 0 for what in ("collisions", "others", "near") for where in ("", "_route")
    }
    for path in sorted(arm.glob("seed-*/outcomes/*.json")):
        outcome = json.loads(path.read_text(encoding="utf-8"))
        spans = [(one["start_s"], one["end_s"] + AFTER_S) for one in outcome["interventions"] if one["moves"]]
        found["moved"] += len(spans)
        events = [("near", one["time_s"]) for one in outcome["near_misses"]]
        for one in outcome["infractions"]:
            if one["kind"] not in NO_HARM:
                what = "collisions" if one["kind"].startswith("collision") else "others"
                events.append((what, one["time_s"]))
        for what, time_s in events:
            found[f"{what}_route"] += 1
            found[what] += any(begin <= time_s <= end for begin, end in spans)
    return found


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
