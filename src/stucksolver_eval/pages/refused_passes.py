"""Each pass still refused, with the sight needed and seen, from the records of an evaluation.

    python -m stucksolver_eval.pages.refused_passes OUT

`OUT` is the folder of an evaluation that was driven with `--record`. Printed is, for each route, the refusal that
lacked the least sight.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

FACTS = ("needed_m", "seen_m", "time_s")


@dataclass(frozen=True)
class RefusedPass:
    """A pass refused for want of sight: of which route, the sight needed and seen (m), and for how long (s)."""

    route: str
    needed_m: float
    seen_m: float
    unseen_s: float


def nearest_of(folder: Path) -> tuple[RefusedPass, ...]:
    """For each route with such a refusal the one that lacked the least, by route. Raises `FileNotFoundError`."""
    files = sorted(folder.rglob("intervention-*.jsonl"))
    if not files:
        raise FileNotFoundError(f"{folder} has no record of an intervention: drive with evaluate --record")
    found: dict[str, RefusedPass] = {}
    for file in files:
        for one in _refusals(file):
            known = found.get(one.route)
            if known is None or one.needed_m - one.seen_m < known.needed_m - known.seen_m:
                found[one.route] = one
    return tuple(found[route] for route in sorted(found))


def _refusals(file: Path) -> Iterator[RefusedPass]:
    for line in file.read_text(encoding="utf-8").splitlines():
        if '"oncoming_sight"' in line:
            for reject in _rejects(json.loads(line)):
                needed_m, seen_m, unseen_s = (float(reject[name]) for name in FACTS)
                yield RefusedPass(file.parent.name, needed_m, seen_m, unseen_s)


def _rejects(value: object) -> Iterator[dict[str, float]]:
    """All reasons for want of sight in a line of a record, wherever they stand in it."""
    if isinstance(value, dict):
        if value.get("code") == "oncoming_sight" and all(value.get(name) is not None for name in FACTS):
            yield value
        for part in value.values():
            yield from _rejects(part)
    elif isinstance(value, list):
        for part in value:
            yield from _rejects(part)


def table(passes: tuple[RefusedPass, ...]) -> str:
    """The passes as a Markdown table."""
    rows = [f"| {p.route} | {p.needed_m:.0f} | {p.seen_m:.0f} | {p.unseen_s:.1f} |" for p in passes]
    return "\n".join(["| route | sight needed, m | seen, m | time, s |", "|---|---|---|---|", *rows])


def main(arguments: list[str] | None = None) -> int:
    """Print the table; 2 where there are no records."""
    parser = argparse.ArgumentParser(description="each pass still refused, with the sight needed and seen")
    parser.add_argument("out", type=Path, help="folder of an evaluation driven with --record")
    try:
        print(table(nearest_of(parser.parse_args(arguments).out)))
    except FileNotFoundError as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
