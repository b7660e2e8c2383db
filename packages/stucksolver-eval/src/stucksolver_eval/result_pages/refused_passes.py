"""Prints the passes that the guard rejected for lack of sight distance, from the records of an evaluation.

```sh
python -m stucksolver_eval.result_pages.refused_passes OUT
```

`OUT` is the folder of an evaluation with `--record`. For each route, the table contains the rejection that came closest
to the required sight distance. The last column is the requirement in the best case: the visible lane ends at a
junction, and all traffic there starts from rest when the pass begins. It uses the guard's own acceleration and margin
(`OncomingPolicy`) and 50 km/h. A pass with less sight distance than that could not be proven even if the lights and
stop lines of all others were known.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from stucksolver.guard import GuardPolicy, PhantomVehicle

FACTS = ("needed_m", "seen_m", "time_s")


@dataclass(frozen=True)
class RefusedPass:
    """A pass that the guard rejected for lack of sight distance.

    Attributes:
        route: Id of the route.
        needed_m: Required sight distance (m).
        seen_m: Available sight distance (m).
        unseen_s: Time in which traffic may come out of the occluded area (s).
    """

    route: str
    needed_m: float
    seen_m: float
    unseen_s: float

    @property
    def least_m(self) -> float:
        """Required sight distance if all occluded traffic started from rest at the end of the visible lane (m)."""
        policy = GuardPolicy().oncoming
        starting = PhantomVehicle(0.0, 0.0, policy.unknown_limit_mps, policy.turned_accelerates_mps2)
        return policy.sight_margin_m + starting.way_m(self.unseen_s)


def nearest_of(folder: Path) -> tuple[RefusedPass, ...]:
    """Return the rejection that came closest to the required sight distance for each route.

    Raises `FileNotFoundError`.
    """
    files = sorted(folder.rglob("intervention-*.jsonl"))
    if not files:
        raise FileNotFoundError(f"no record of an intervention in folder: {folder}. Drive with evaluate --record")
    found: dict[str, RefusedPass] = {}
    for file in files:
        for refusal in _refusals(file):
            known = found.get(refusal.route)
            if known is None or refusal.needed_m - refusal.seen_m < known.needed_m - known.seen_m:
                found[refusal.route] = refusal
    return tuple(found[route] for route in sorted(found))


def _refusals(file: Path) -> Iterator[RefusedPass]:
    for line in file.read_text(encoding="utf-8").splitlines():
        if '"oncoming_sight"' in line:
            for reject in _rejects(json.loads(line)):
                needed_m, seen_m, unseen_s = (float(reject[name]) for name in FACTS)
                yield RefusedPass(file.parent.name, needed_m, seen_m, unseen_s)


def _rejects(value: object) -> Iterator[dict[str, float]]:
    """Yield all rejections for lack of sight distance in a line of a record, at any depth."""
    if isinstance(value, dict):
        if value.get("code") == "oncoming_sight" and all(value.get(name) is not None for name in FACTS):
            yield value
        for part in value.values():
            yield from _rejects(part)
    elif isinstance(value, list):
        for part in value:
            yield from _rejects(part)


def table(passes: tuple[RefusedPass, ...]) -> str:
    """Return the passes as a Markdown table."""
    rows = [f"| {p.route} | {p.needed_m:.0f} | {p.seen_m:.0f} | {p.unseen_s:.1f} | {p.least_m:.0f} |" for p in passes]
    return "\n".join(
        ["| route | sight needed, m | seen, m | time, s | in the best case, m |", "|---|---|---|---|---|", *rows]
    )


def main(arguments: list[str] | None = None) -> int:
    """Print the table. Exits with 2 if there are no records."""
    parser = argparse.ArgumentParser(
        description="Prints the passes that the guard rejected for lack of sight distance."
    )
    parser.add_argument("out", type=Path, help="folder of an evaluation with --record")
    try:
        print(table(nearest_of(parser.parse_args(arguments).out)))
    except FileNotFoundError as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
