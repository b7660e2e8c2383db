"""Drives accepted plans in closed loop, and checks whether a contact happens that the guard should prevent.

```
python -m lab.benchmarks.guard_oracle --out out/guard_oracle --plans 20000 --jobs 32
```

It resumes after an interruption; the result does not depend on `--jobs`. It prints progress to standard error, and
writes `seed-N.json`: the counts by class and by cause, and every contact. `stucksolver_eval.result_pages.guard_oracle`
turns it into a page. `--show SCENE K` drives one proposal again and prints its row.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from lab.benchmarks.guard_oracle.campaign import one
from lab.benchmarks.guard_oracle.scene import all_classes
from lab.benchmarks.guard_oracle.shares import scenes_in_order
from lab.benchmarks.guard_oracle.summary import Row, Summary, of_scene

REPORT_S = 15.0
"""Time between two reports (s)."""


def resumed(path: Path, summary: Summary) -> int:
    """Add the finished scenes of an interrupted campaign, and return the position of the next one.

    A line that was cut off is removed from the file.
    """
    whole: list[str] = []
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        try:
            scene = json.loads(line)
        except ValueError:
            # The last line of an interrupted campaign may be cut off; its scene is done again.
            break
        summary.add(scene)
        whole.append(line)
    path.write_text("".join(line + "\n" for line in whole), encoding="utf-8")
    return json.loads(whole[-1])["place"] + 1 if whole else 0


def campaign(
    out: Path,
    seed: int,
    plans: int,
    scenes: int | None = None,
    judge_only: bool = False,
    classes: tuple[str, ...] | None = None,
    jobs: int = 1,
    only: int | None = None,
) -> Row:
    """Continue until this number of accepted plans was driven, or of scenes is done; return the summary.

    The classes have scenes in turn. `judge_only`: drive no plan, and store every row. `jobs`: number of processes.
    `only`: the number of one proposal in each scene; None for all.
    """
    out.mkdir(parents=True, exist_ok=True)
    path, summary = out / f"seed-{seed}.jsonl", Summary()
    first = resumed(path, summary)
    places = places_of(first, scenes, classes or all_classes())
    began = reported = time.monotonic()
    before = summary.counts["driven"]
    with path.open("a", encoding="utf-8") as file:
        work = scenes_in_order(seed, places, judge_only, jobs, only) if summary.counts["driven"] < plans else iter(())
        for place, name, number, rows in work:
            scene = of_scene(place, name, number, rows, judge_only)
            summary.add(scene)
            file.write(json.dumps(scene) + "\n")
            now = time.monotonic()
            if now - reported > REPORT_S:
                file.flush()
                reported = now
                speed = (summary.counts["driven"] - before) / (now - began)
                print(f"{summary.brief()}; {speed:.1f} plans/s", file=sys.stderr, flush=True)
            if summary.counts["driven"] >= plans:
                break
    data = {"seed": seed, **summary.data()}
    path.with_suffix(".json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    return data


def places_of(first: int, scenes: int | None, classes: tuple[str, ...]) -> Iterator[tuple[int, str, int]]:
    """Yield (position in the campaign, class, number of the scene of that class) from a position on."""
    place, names = first, all_classes()
    while scenes is None or place < scenes:
        k, which = divmod(place, len(names))
        if names[which] in classes:
            yield place, names[which], k
        place += 1


def main() -> None:
    """Print one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/guard_oracle"))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plans", type=int, default=20000, help="number of accepted plans to drive")
    parser.add_argument("--scenes", type=int, help="stop after this many scenes at the latest")
    parser.add_argument("--classes", nargs="+", choices=all_classes(), help="scenes of these classes (default: all)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="number of processes (default: cores)")
    parser.add_argument("--judge-only", action="store_true", help="judge the plans, but drive none; keeps every row")
    parser.add_argument("--own-only", action="store_true", help="only the plan that the search finds in each scene")
    parser.add_argument("--show", type=int, nargs=2, metavar=("SCENE", "K"), help="drive one proposal again")
    options = parser.parse_args()
    if options.show:
        print(json.dumps(one(options.seed, *options.show), indent=1))
        return
    classes = tuple(options.classes) if options.classes else None
    only = 0 if options.own_only else None
    data = campaign(
        options.out, options.seed, options.plans, options.scenes, options.judge_only, classes, options.jobs, only
    )
    print(json.dumps({key: data[key] for key in ("seed", "scenes", "driven_s", "counts", "causes")}), flush=True)


if __name__ == "__main__":
    main()
