"""Prints stored results as tables: `python -m stucksolver_eval.result_pages.result_tables NAME`.

Names are the folders of `results`, such as `bench220`, `dev`, `immobilized`, `wrong` and `latency`.

With two names, it compares the runs that both contain, seed by seed: `python -m
stucksolver_eval.result_pages.result_tables dev dev-now`.

With `--write`, the tables replace those in `results/NAME.md` with the same first three column heads.
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
from pathlib import Path
from typing import Any

from stucksolver_eval.metrics.paired_statistics import Interval, bootstrap, compare_pairs
from stucksolver_eval.result_pages import RESULTS

Summary = dict[str, Any]

PLANNER = "planner-"
"""Prefix of the systems with the driver `planner`. All others have the driver `behavior:normal`."""


def scores(arms: dict[str, Summary]) -> list[list[str]]:
    """Return the table of Bench2Drive's scores, one row per system."""
    head = _cells("arm | DS | SR % | route % | infractions | efficiency | (corrected) | comfort | (corrected)")
    keys = "driving_score success_rate route_completion infraction_score efficiency efficiency_corrected comfort"
    rows = []
    for name, arm in arms.items():
        values = [arm[key] for key in (*keys.split(), "comfort_corrected")]
        digits = [3 if key == "infraction_score" else 1 for key in keys.split()] + [1]
        rows.append([name, *(_figure(value, digit) for value, digit in zip(values, digits, strict=True))])
    return [head, *rows]


def abilities(arms: dict[str, Summary]) -> list[list[str]]:
    """Return the table of Bench2Drive's abilities (%)."""
    names = list(next(iter(arms.values()))["abilities"])
    return [
        ["arm", *(name.replace("_", " ") for name in names)],
        *([arm, *(_figure(item["abilities"][name], 1) for name in names)] for arm, item in arms.items()),
    ]


def recovery(arms: dict[str, Summary]) -> list[list[str]]:
    """Return the table of recovery metrics. Harm counts from the start of a plan to 10 s after its end."""
    head = _cells(
        "arm | episodes | resolved | median s | p95 s | plans | recovered | by rung"
        " | false | missed | harm | right | queries | lost s"
    )
    rows = []
    for name, arm in arms.items():
        it = arm["recovery"]
        rungs = ", ".join(f"{rung} {count}" for rung, count in sorted(it["by_rung"].items()))
        right = f"{it['right']}/{it['judged']}" if it["judged"] else "–"
        counts = [str(it[key]) for key in ("met", "left")]
        times = [_figure(it[key], 1) for key in ("median_s", "p95_s")]
        plans = [str(it["interventions"]), str(it["recovered"]), rungs or "–"]
        wrong = [str(it[key]) for key in ("false", "missed", "harm")]
        cost = [_figure((it.get("model_queries") or it["queries"]) / max(it["routes"], 1), 1), _figure(it["lost_s"], 0)]
        rows.append([name, *counts, *times, *plans, *wrong, right, *cost])
    return [head, *rows]


def differences(folder: Path, arms: dict[str, Summary]) -> list[list[str]]:
    """Return means with 95 % intervals of a bootstrap over routes, and the differences from the same driver alone."""
    rows = [_cells("arm | DS | vs. alone | p | SR % | vs. alone | p")]
    for name in arms:
        cells = [name]
        baseline = _driver_alone(name)
        alone = _by_route(folder / baseline / "routes.csv")
        own = _by_route(folder / name / "routes.csv")
        for column, factor in (("driving_score", 1.0), ("success", 100.0)):
            values = {route: {k: factor * float(row[column]) for k, row in item.items()} for route, item in own.items()}
            cells.append(_between(bootstrap([list(value.values()) for value in values.values()])))
            if name == baseline:
                cells += ["–", "–"]
                continue
            less = [[v - factor * float(alone[r][k][column]) for k, v in value.items()] for r, value in values.items()]
            paired = compare_pairs(less)
            cells += [_between(paired.difference), f"{paired.p:.4f}"]
        rows.append(cells)
    return rows


def _driver_alone(arm: str) -> str:
    """Return the system with the driver of `arm` alone."""
    return f"{PLANNER}alone" if arm.startswith(PLANNER) else "alone"


def by_type(folder: Path, arms: dict[str, Summary]) -> list[list[str]]:
    """Return the number of successful runs of each scenario type, one column per system.

    If the suite states the right action on a route (`recover`, `wait`, `ask`, `reroute`), a column contains it.
    """
    drives = {name: list(csv.DictReader((folder / name / "routes.csv").open(encoding="utf-8"))) for name in arms}
    kinds = sorted({row["scenario"] for rows in drives.values() for row in rows})
    right = {row["scenario"]: row["expected"] for rows in drives.values() for row in rows if row["expected"]}
    table = [["type", *(["right is to"] if right else []), "drives", *arms]]
    for kind in kinds:
        expected = [right.get(kind, "–")] if right else []
        of_kind = [[int(row["success"]) for row in rows if row["scenario"] == kind] for rows in drives.values()]
        most = max(len(successes) for successes in of_kind)
        counts = [str(sum(successes)) if successes else "–" for successes in of_kind]
        table.append([kind, *expected, str(most), *counts])
    return table


def _by_route(path: Path) -> dict[str, dict[str, dict[str, str]]]:
    """Return the rows of a CSV file by route and seed."""
    found: dict[str, dict[str, dict[str, str]]] = {}
    for row in csv.DictReader(path.read_text(encoding="utf-8").splitlines()):
        found.setdefault(row["route_id"], {})[row["seed"]] = row
    return found


def _between(interval: Interval) -> str:
    # Adding 0.0 turns -0.0 into 0.0.
    mean, low, high = (round(value, 1) + 0.0 for value in (interval.mean, interval.low, interval.high))
    return f"{mean:.1f} [{low:.1f}, {high:.1f}]"


def moved(before: Path, after: Path) -> list[list[str]]:
    """Compare the runs that both folders contain: means, and the routes with a different outcome."""
    rows = [_cells("arm | drives | DS | SR % | plans | lost | won")]
    for path in sorted(after.glob("*/routes.csv")):
        arm = path.parent.name
        if not (before / arm).is_dir():
            continue
        old, new = (_drives(folder / arm / "routes.csv") for folder in (before, after))
        both = sorted(old.keys() & new.keys())
        cells = [arm, str(len(both))]
        for column, factor in (("driving_score", 1.0), ("success", 100.0)):
            means = (factor * sum(float(item[key][column]) for key in both) / len(both) for item in (old, new))
            cells.append(" → ".join(f"{value:.1f}" for value in means))
        cells.append(" → ".join(str(sum(int(item[key]["interventions"]) for key in both)) for item in (old, new)))
        for first, second in ((old, new), (new, old)):
            ahead = [key for key in both if first[key]["success"] > second[key]["success"]]
            names = [f"{key[0]} {old[key]['scenario']}" for key in ahead]
            cells.append(", ".join(names) or "–")
        rows.append(cells)
    return rows


def _drives(path: Path) -> dict[tuple[str, str], dict[str, str]]:
    return {(route, seed): row for route, seeds in _by_route(path).items() for seed, row in seeds.items()}


def harm(arms: dict[str, Summary]) -> list[list[str]]:
    """Return the table of events during plans that move; in brackets, on the whole route."""
    head = _cells("arm | DS | SR % | plans that move | collisions | other infractions | near misses | false | missed")
    rows = []
    for name, arm in arms.items():
        plans, it = arm["plans"], arm["recovery"]
        cells = [f"{plans[what]} ({plans[what + '_route']})" for what in ("collisions", "others", "near")]
        scored = [_figure(arm["driving_score"], 1), _figure(arm["success_rate"], 1), str(plans["moved"])]
        rows.append([name, *scored, *cells, str(it["false"]), str(it["missed"])])
    return [head, *rows]


def _cells(line: str) -> list[str]:
    return line.split(" | ")


def _figure(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:,.{digits}f}"


def _printed(rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]]) + "\n"


class ResultPageError(ValueError):
    """A page lacks a table. The message contains the required head."""


def tables_of(name: str, later: str | None = None) -> list[str]:
    """Return the tables of one folder of results, or the comparison of two, in Markdown."""
    if later:
        return [_printed(moved(RESULTS / name, RESULTS / later))]
    arms = {
        path.parent.name: json.loads(path.read_text(encoding="utf-8"))
        for path in sorted((RESULTS / name).glob("*/summary.json"))
    }
    if not arms:
        raise SystemExit(
            f"no summary in folder: {RESULTS / name}. "
            "Run results/run.sh, then stucksolver_eval.result_pages.archive_results"
        )
    if name.startswith("wrong"):
        return [
            f"## `{suite}`\n\n"
            + _printed(harm({arm.split("-", 1)[1]: item for arm, item in arms.items() if arm.startswith(suite)}))
            for suite in dict.fromkeys(arm.split("-")[0] for arm in arms)
        ]
    tables = [scores(arms), recovery(arms)]
    if any(value is not None for item in arms.values() for value in item["abilities"].values()):
        tables.append(abilities(arms))
    if "alone" in arms:
        tables.append(differences(RESULTS / name, arms))
    if name.removesuffix("-now") in ("bench220", "dev", "immobilized"):
        tables.append(by_type(RESULTS / name, arms))
    return [_printed(table) for table in tables]


def replaced(page: str, table: str) -> str:
    """Return the page with the table in place of the one with the same first three column heads.

    Raises:
        ResultPageError: The page has no such table, or several.
    """
    head = _heads(table.splitlines()[0])
    lines = page.splitlines()
    found = [
        at for at, line in enumerate(lines) if _heads(line) == head and "".join(lines[at + 1 : at + 2]).startswith("|-")
    ]
    if len(found) != 1:
        raise ResultPageError(f"{len(found)} tables begin with | {' | '.join(head)} |; the page needs exactly one")
    end = next((at for at in range(found[0], len(lines)) if not lines[at].startswith("|")), len(lines))
    return "\n".join([*lines[: found[0]], *table.splitlines(), *lines[end:]]) + "\n"


def _heads(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")][:3]


def main(arguments: list[str]) -> None:
    """Print the tables, or write them into their page."""
    parser = argparse.ArgumentParser(
        prog="stucksolver_eval.result_pages.result_tables", description="Prints stored results."
    )
    parser.add_argument("name", help="folder in results")
    parser.add_argument("later", nargs="?", help="a second folder, to compare with")
    parser.add_argument("--write", action="store_true", help="replace the tables in results/NAME.md")
    asked = parser.parse_args(arguments)
    tables = tables_of(asked.name, asked.later)
    if not asked.write:
        print("\n".join(tables), end="")
        return
    path = RESULTS / f"{asked.name}.md"
    page = path.read_text(encoding="utf-8")
    for table in tables:
        page = replaced(page, table)
    path.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
