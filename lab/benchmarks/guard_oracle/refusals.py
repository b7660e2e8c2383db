"""Compares two guards on the same proposals: lists those that are newly rejected, and whether that was right.

```
PYTHONPATH=OLD/src python -m lab.benchmarks.guard_oracle --judge-only --scenes 600 --out out/before
python -m lab.benchmarks.guard_oracle --judge-only --scenes 600 --out out/after
python -m lab.benchmarks.guard_oracle.refusals out/before/seed-1.jsonl out/after/seed-1.jsonl refusals.json
```

Each newly rejected plan is driven without a guard (`harm.py`).
"""

from __future__ import annotations

import argparse
import json
import re
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

from lab.benchmarks.guard_oracle.campaign import Row, setting_of
from lab.benchmarks.guard_oracle.harm import harm_of
from lab.benchmarks.guard_oracle.others import AlongLane
from stucksolver.plan import RecoveryPlan

Key = tuple[int, int]


def rows_of(path: Path) -> tuple[int, dict[Key, Row]]:
    """Return the seed of a campaign, read from its file name, and its proposals by scene and number."""
    seed = re.search(r"seed-(\d+)", path.name)
    if seed is None:
        raise SystemExit(f"no seed in the file name: {path}. Name it like seed-1.jsonl")
    scenes = (json.loads(line) for line in path.read_text(encoding="utf-8").splitlines())
    return int(seed[1]), {(row["scene"], row["k"]): row for scene in scenes for row in scene["rows"]}


def has_follower(seed: int, row: Row) -> bool:
    """True if it is a lane change with a follower in the lane to be entered."""
    change = next((b for b in row["plan"] if b["name"] == "change_lane"), None)
    if change is None:
        return False
    _, setting = setting_of(seed, row["scene"])
    lane = next((lane for lane in setting.road.lanes if lane.name == change["side"]), None)
    if lane is None:
        return False
    return any(
        isinstance(o, AlongLane)
        and o.way > 0
        and o.v > 0.5
        and o.s < setting.ego_s
        and lane.right_m < o.d < lane.left_m
        for o in setting.others
    )


def compare(before: Path, after: Path) -> dict[str, Any]:
    """Return counts by class, and every new rejection with the outcome of the drive without a guard."""
    seed, old = rows_of(before)
    again, new = rows_of(after)
    if seed != again:
        raise SystemExit(
            f"different seeds: {before} has {seed}, {after} has {again}. Both files must have the same scenes"
        )
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    refused = []
    for key, was in old.items():
        now = new.get(key)
        if now is None or now["plan"] != was["plan"]:
            counts["other plans"]["proposed"] += 1
            continue
        groups = [was["class"]] + (["change_lane with a follower"] if has_follower(seed, was) else [])
        for group in groups:
            counts[group]["proposed"] += 1
            counts[group]["before"] += was["accepted"]
            counts[group]["after"] += now["accepted"]
            counts[group]["newly accepted"] += now["accepted"] and not was["accepted"]
        if was["accepted"] and not now["accepted"]:
            harm = harm_of(seed, key[0], RecoveryPlan.model_validate({"behaviors": was["plan"]}), now["codes"])
            shown = harm.justifies(now["codes"])
            for group in groups:
                counts[group]["newly refused"] += 1
                counts[group]["with harm shown"] += shown
            refused.append(
                {
                    "scene": key[0],
                    "k": key[1],
                    "groups": groups,
                    "behaviors": [b["name"] for b in was["plan"]],
                    "why": now["why"],
                    "contact": harm.contact,
                    "brakes_mps2": round(harm.brakes_mps2, 1),
                    "off_lane_m": round(harm.off_lane_m, 2),
                    "off_road_m": round(harm.off_road_m, 2),
                    "harm": shown,
                }
            )
    return {"seed": seed, "counts": {name: dict(found) for name, found in counts.items()}, "refused": refused}


def main() -> None:
    """Write the comparison as JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("out", type=Path)
    options = parser.parse_args()
    found = compare(options.before, options.after)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
