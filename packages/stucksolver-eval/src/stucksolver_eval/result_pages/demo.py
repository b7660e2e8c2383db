"""Drives the demonstration on six maps and prints a table: `python -m stucksolver_eval.result_pages.demo OUT`.

`STUCKSOLVER_MAPS` must name a folder with CARLA's towns. This takes about seven minutes; the drives are stored in OUT.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Literal

from stucksolver_eval.demo import DemoSpec, demo
from stucksolver_eval.results.run_log import RunLog
from stucksolver_eval.run_table import recovered_text, stopped_text

Road = Literal["one_lane", "multi_lane"]
STREETS: tuple[tuple[str, Road, int], ...] = (
    ("demo_town", "one_lane", 3),
    ("demo_town", "multi_lane", 0),
    ("Town01", "one_lane", 0),
    ("Town01", "one_lane", 4),
    ("Town02", "one_lane", 3),
    ("Town04", "multi_lane", 0),
    ("Town04", "one_lane", 3),
    ("Town10HD", "multi_lane", 0),
)
HEAD = "| map | street | who drives | ended | route % | infractions | stopped s | recovered s | decisions | plans |"


def main(out: Path) -> None:
    """Drive all streets and print the table. Raises the errors of `demo`; completed drives stay in `out`."""
    print(HEAD, "|" + "---|" * HEAD.count(" | ") + "---|", sep="\n", flush=True)
    for town, road, oncoming in STREETS:
        spec = DemoSpec(map_name=town, road=road, oncoming=oncoming, out=out / f"{town}-{road}-{oncoming}")
        for log in demo(spec, lambda text: None)[0]:
            print(_row(town, log), flush=True)


def _row(town: str, log: RunLog) -> str:
    r = log.result
    infractions = ", ".join(f"{name} {count}" for name, count in sorted(r.infractions.items())) or "none"
    cells = [town, log.scenario, log.arm, r.status, f"{r.route_completion_pct:.0f}", infractions]
    cells += [stopped_text(r), recovered_text(r), str(r.decisions), str(r.plans_accepted)]
    return "| " + " | ".join(cells) + " |"


if __name__ == "__main__":
    main(Path(sys.argv[1]))
