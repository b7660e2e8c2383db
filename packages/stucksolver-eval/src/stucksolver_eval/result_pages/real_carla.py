"""Compares runs on carlette with the same agent's published runs on real CARLA.

```sh
python -m stucksolver_eval.result_pages.real_carla keep results/real_carla.json windows=DIR linux=DIR before=DIR \
    after=DIR
python -m stucksolver_eval.result_pages.real_carla table results/real_carla.json
```

`keep` reads the checkpoint files (`*.json` with `_checkpoint.records`) of Bench2Drive's evaluator in each folder,
recursively, and stores status, driving score, success and game time of each record. Entries of the file under other
names stay. `table` compares every other name with the first one. docs/real-carla.md has the procedure.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

TOWNS = ("Town01", "Town02", "Town04", "Town10HD")
SCORE_WITHIN = 3.0
"""Largest difference at which driving scores agree. Ours."""
CLOSE, CLOSE_S, NEAR = 0.05, 1.0, 0.15
"""Largest differences at which times agree closely (share, s), and at which they agree roughly (share). Ours."""
FORGIVEN = "min_speed_infractions"
"""Infractions of this kind do not count as a failure in Bench2Drive's success rate."""
HALVES = ("tuning", "test")


class PublishedRun(NamedTuple):
    """One drive of one route: driving score 0 to 100, game time in seconds."""

    status: str
    score: float
    success: bool
    game_s: float


class RealRoute(NamedTuple):
    """One route and its drives, by name."""

    town: str
    scenario: str
    drives: dict[str, PublishedRun]


Routes = dict[str, RealRoute]
"""By route id."""


def half(route: str) -> str:
    """Return the half to which a route belongs, `tuning` or `test`, from its hash. It was fixed before any tuning."""
    return HALVES[hashlib.sha256(route.encode()).digest()[0] % 2]


def records(folder: Path) -> Iterator[tuple[str, Any]]:
    """Yield route id and record. Raises `SystemExit` if there is none."""
    found = 0
    for file in sorted(folder.rglob("*.json")):
        content = json.loads(file.read_text(encoding="utf-8"))
        if isinstance(content, dict):
            for record in content.get("_checkpoint", {}).get("records", ()):
                number = re.search(r"\d+", record["route_id"])
                if number and "town_name" in record:
                    found += 1
                    yield number.group(), record
    if not found:
        raise SystemExit(f"no checkpoint file with records in folder: {folder}. Give a folder of result files")


def drive_of(record: Any) -> PublishedRun:
    """Return the facts of a record that are stored."""
    failures = [kind for kind, texts in record["infractions"].items() if texts and kind != FORGIVEN]
    success = record["status"] in ("Completed", "Perfect") and not failures
    score, game_s = record["scores"]["score_composed"], record["meta"]["duration_game"]
    return PublishedRun(record["status"], round(float(score), 2), success, round(float(game_s), 2))


def load(file: Path) -> Routes:
    """Return the content of a file from `keep`; empty without a file."""
    stored = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    return {
        key: RealRoute(
            item["town"], item["scenario"], {name: PublishedRun(*facts) for name, facts in item["drives"].items()}
        )
        for key, item in stored.items()
    }


def keep(file: Path, sources: Iterable[tuple[str, Path]]) -> None:
    """Add the drives of each named folder to `file`, replacing those of the same name."""
    routes = load(file)
    for name, folder in sources:
        for route in routes.values():
            route.drives.pop(name, None)
        for number, record in records(folder):
            if record["town_name"] in TOWNS:
                scenario = record["scenario_name"].rpartition("_")[0]
                route = routes.setdefault(number, RealRoute(record["town_name"], scenario, {}))
                route.drives[name] = drive_of(record)
    lines = [f"{json.dumps(key)}: {json.dumps(item._asdict())}" for key, item in sorted(routes.items())]
    file.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def table(routes: Routes) -> str:
    """Return Markdown tables: agreement of all others with the first, by half and in total; then each route."""
    names = list(dict.fromkeys(name for route in routes.values() for name in route.drives))
    real, others = names[0], names[1:]
    head = f"| | routes | success as {real} | score within 3 | time within 5 % or 1 s | within 15 % | median ratio |"
    lines = [head, "|---" * 7 + "|"]
    for name in others:
        for part in (*HALVES, "all"):
            pairs = [
                (route.drives[real], route.drives[name])
                for key, route in routes.items()
                if part in ("all", half(key)) and {real, name} <= set(route.drives)
            ]
            lines.append(f"| {name}, {part} | " + " | ".join(_agreement(pairs)) + " |")
    lines += ["", "| route | town | scenario | half | " + " | ".join(names) + " |", "|---" * (len(names) + 4) + "|"]
    for key, route in routes.items():
        cells = [_cell(route.drives.get(name), route.drives.get(real), name == real) for name in names]
        lines.append(f"| {key} | {route.town} | {route.scenario} | {half(key)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _agreement(pairs: list[tuple[PublishedRun, PublishedRun]]) -> list[str]:
    if not pairs:
        return ["0", *["–"] * 5]
    apart = [(abs(b.game_s - a.game_s), a.game_s) for a, b in pairs]
    counts = (
        len(pairs),
        sum(a.success == b.success for a, b in pairs),
        sum(abs(a.score - b.score) <= SCORE_WITHIN for a, b in pairs),
        sum(gap_s <= max(CLOSE * game_s, CLOSE_S) for gap_s, game_s in apart),
        sum(gap_s <= max(NEAR * game_s, CLOSE_S) for gap_s, game_s in apart),
    )
    return [*map(str, counts), f"{median(b.game_s / a.game_s for a, b in pairs):.2f}"]


def _cell(drive: PublishedRun | None, real: PublishedRun | None, is_real: bool) -> str:
    if drive is None:
        return "–"
    ratio = f" ({drive.game_s / real.game_s:.2f})" if real and not is_real else ""
    return f"{drive.score:g}, {drive.game_s:.1f} s{ratio}"


def main(arguments: list[str]) -> None:
    """Run one of the commands in the module's docstring."""
    if len(arguments) >= 3 and arguments[0] == "keep" and all("=" in argument for argument in arguments[2:]):
        keep(
            Path(arguments[1]),
            [(name, Path(folder)) for name, _, folder in (argument.partition("=") for argument in arguments[2:])],
        )
    elif len(arguments) == 2 and arguments[0] == "table":
        print(table(load(Path(arguments[1]))))
    else:
        raise SystemExit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
