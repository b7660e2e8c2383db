"""Copies the summaries of evaluations into a folder of this one: `python results/keep.py OUT/latency latency`.

Only what is small and repeatable: `summary.json` and `routes.csv` of each arm, without wall times and paths.
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
        (folder / "summary.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
        (folder / "routes.csv").write_text(_routes(summary.with_name("routes.csv")), encoding="utf-8")
        done.append(arm)
    return done


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
