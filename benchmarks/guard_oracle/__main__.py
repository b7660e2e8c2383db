"""Drives accepted plans in closed loop: does a contact happen that the guard promised to avoid?

    python -m benchmarks.guard_oracle --out out/guard_oracle --plans 20000

Resumes after an interruption. Prints progress to standard error; `stucksolver_eval.pages.guard_oracle` makes a page of
its output. `--show SCENE K` drives one proposal again and prints its row.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from pathlib import Path

from benchmarks.guard_oracle.campaign import one, scene_rows
from benchmarks.guard_oracle.scene import all_classes, number_of

REPORT_S = 30.0


def resume(path: Path) -> tuple[int, Counter[str]]:
    """The next scene's number, and the counts so far. Rows of an unfinished scene are removed from the file."""
    counts: Counter[str] = Counter()
    kept, pending, following = [], [], 0
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                row = json.loads(line)
            except ValueError:
                break
            pending.append(line)
            if row.get("done") is not None:
                kept += pending
                for each in pending[:-1]:
                    count(json.loads(each), counts)
                pending, following = [], row["done"] + 1
        path.write_text("".join(line + "\n" for line in kept), encoding="utf-8")
    return following, counts


def count(row: dict[str, object], counts: Counter[str]) -> None:
    """Adds a row to the counts."""
    counts["proposed"] += 1
    counts["accepted"] += bool(row["accepted"])
    counts["driven"] += bool(row.get("driven"))
    counts["contacts"] += "contact" in row
    counts["not excluded"] += "contact" in row and row["excluded"] is None
    counts["missed"] += bool(row.get("missed"))


def campaign(
    out: Path,
    seed: int,
    plans: int,
    scenes: int | None,
    judge_only: bool = False,
    classes: tuple[str, ...] | None = None,
) -> Counter[str]:
    """Continues until this number of accepted plans has been driven, or of scenes is done. Returns the counts."""
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"seed-{seed}.jsonl"
    number, counts = resume(path)
    reported = time.monotonic()
    with path.open("a", encoding="utf-8") as file:
        while counts["driven"] < plans and (scenes is None or number < scenes):
            k, place = divmod(number, len(all_classes()))
            name = all_classes()[place]
            for row in scene_rows(seed, number_of(name, k), judge_only) if name in (classes or all_classes()) else ():
                count(row, counts)
                file.write(json.dumps(row) + "\n")
            file.write(json.dumps({"done": number}) + "\n")
            file.flush()
            number += 1
            if time.monotonic() - reported > REPORT_S:
                reported = time.monotonic()
                print(f"scene {number}: {dict(counts)}", file=sys.stderr, flush=True)
    return counts


def main() -> None:
    """Prints one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/guard_oracle"))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plans", type=int, default=20000, help="number of accepted plans to drive")
    parser.add_argument("--scenes", type=int, help="stop after this many scenes at the latest")
    parser.add_argument("--classes", nargs="+", choices=all_classes(), help="scenes of these classes (default: all)")
    parser.add_argument("--judge-only", action="store_true", help="judge the plans, but drive none")
    parser.add_argument("--show", type=int, nargs=2, metavar=("SCENE", "K"), help="drive one proposal again")
    options = parser.parse_args()
    classes = tuple(options.classes or all_classes())
    if options.show:
        print(json.dumps(one(options.seed, *options.show), indent=1))
        return
    print(
        json.dumps(
            dict(campaign(options.out, options.seed, options.plans, options.scenes, options.judge_only, classes))
        ),
        flush=True,
    )


if __name__ == "__main__":
    main()
