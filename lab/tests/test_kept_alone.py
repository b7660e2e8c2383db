"""In no kept table does the vehicle do worse with the add-on than alone, except where this file names the cause."""

from __future__ import annotations

import csv
import json
from collections import defaultdict
from pathlib import Path

from stucksolver_eval.result_pages import RESULTS

SLACK = 1e-9
NOT_THE_ADD_ON = ("timers", "unguarded")
"""Baselines, and experiments without the guard."""

Route = tuple[str, str]
"""Route and traffic seed."""
Scores = dict[str, dict[Route, float]]
"""Driving scores by arm and route."""

NEVER_ENDED = "a safe stop did not end although its reason was gone, or nothing had been in the path"
"""Driven before a stop ended by itself. The reasoner of these arms is silent or wrong, or it is 1321: a stream, with
nothing in the path."""
OTHER_TRAFFIC = "after plans of a random reasoner, the driver meets a dense flow at another moment, or time is lost"
ONE_PLAN = "after one plan, the vehicle stands before a stream and is stopped at 186 s; not explained further"

ROUNDABOUT = frozenset({"3060", "3061", "3062", "3063", "3064"})
LEAVES_BY_ITSELF = frozenset(
    {"3130", "3131", "3132", "3133", "3134", "3202", "3203", "3220", "3221", "3222", "3223", "3224"}
)
EXCEPTIONS: dict[str, dict[str, frozenset[str]]] = {
    "latency/latency-0": {NEVER_ENDED: frozenset({"1321"})},
    "sensors/bench220-rules": {ONE_PLAN: frozenset({"1204"})},
    "wrong/bench220-random": {OTHER_TRAFFIC: frozenset({"1081", "1150", "1152", "1203", "1313", "1330", "1334"})},
    "wrong/bench220-random-later": {OTHER_TRAFFIC: frozenset({"1324"})},
    "wrong/dev-always_drive_over": {NEVER_ENDED: frozenset({"1321"})},
    "wrong/dev-always_left": {NEVER_ENDED: frozenset({"1321"})},
    "wrong/dev-late": {NEVER_ENDED: frozenset({"1321"})},
    "wrong/dev-rules": {NEVER_ENDED: frozenset({"1321"})},
    "wrong/dev-silent": {NEVER_ENDED: frozenset({"1321"})},
    "wrong/immobilized-always_drive_over": {NEVER_ENDED: ROUNDABOUT | LEAVES_BY_ITSELF},
    "wrong/immobilized-always_left": {NEVER_ENDED: ROUNDABOUT | LEAVES_BY_ITSELF},
    "wrong/immobilized-late": {NEVER_ENDED: LEAVES_BY_ITSELF},
    "wrong/immobilized-random": {OTHER_TRAFFIC: ROUNDABOUT},
    "wrong/immobilized-silent": {NEVER_ENDED: ROUNDABOUT | LEAVES_BY_ITSELF},
}
"""Routes on which an arm is worse than its driver alone, by table and cause. A table that is driven anew takes its rows
out of this list."""
MOST_EXCEPTIONS = 83
"""The number of routes in this list, which may only get smaller."""


def tables(results: Path) -> dict[str, Scores]:
    """Return all kept driving scores: by folder of arms, or by file of Bench2Drive's evaluator."""
    found: dict[str, Scores] = defaultdict(dict)
    for file in sorted(results.glob("**/routes.csv")):
        with file.open(encoding="utf-8", newline="") as rows:
            scores = {(row["route_id"], row["seed"]): float(row["driving_score"]) for row in csv.DictReader(rows)}
        found[file.parent.parent.relative_to(results).as_posix()][file.parent.name] = scores
    for file in sorted(results.glob("**/*.json")):
        data = json.loads(file.read_text(encoding="utf-8"))
        for run in data.get("runs", ()) if isinstance(data, dict) else ():
            if isinstance(run, list):
                arm, seed, route, score = run[0], str(run[1]), run[2], float(run[6])
                scores = found[file.relative_to(results).with_suffix("").as_posix()].setdefault(arm, {})
                scores[(route, seed)] = score
    return found


def alone_for(arm: str, arms: Scores) -> str | None:
    """Return the arm with the same driver and without the add-on, or None if it is not kept beside this one."""
    parts = arm.split("-")
    if parts[-1] == "alone" or any(part in NOT_THE_ADD_ON for part in parts):
        return None
    names = ["-".join((*parts[:k], "alone")) for k in range(len(parts) - 1, -1, -1)]
    return next((name for name in names if name in arms), None)


def worse(results: Path) -> dict[str, frozenset[str]]:
    """Return the routes on which an arm has a lower score than its driver alone, by table."""
    found: dict[str, frozenset[str]] = {}
    for folder, arms in tables(results).items():
        for arm, scores in arms.items():
            alone = arms.get(alone_for(arm, arms) or "", {})
            routes = frozenset(key[0] for key, score in scores.items() if score < alone.get(key, score) - SLACK)
            if routes:
                found[f"{folder}/{arm}"] = routes
    return found


def test_kept_tables_no_arm_is_worse_than_alone_but_named():
    """A new exception fails, and so does a named one that no longer occurs."""
    named = {table: frozenset().union(*causes.values()) for table, causes in EXCEPTIONS.items()}
    assert worse(RESULTS) == named
    assert sum(map(len, named.values())) == MOST_EXCEPTIONS <= 83


def test_kept_tables_compare_many_drives():
    """The comparison finds its pairs: nearly all arms with the add-on have their driver alone beside them."""
    compared = sum(
        len(scores.keys() & arms[alone].keys())
        for arms in tables(RESULTS).values()
        for arm, scores in arms.items()
        if (alone := alone_for(arm, arms)) is not None
    )
    assert compared > 4_500


def test_kept_tables_worse_drive_is_found(tmp_path):
    def keep(arm, score):
        folder = tmp_path / "suite" / arm
        folder.mkdir(parents=True)
        (folder / "routes.csv").write_text(f"route_id,seed,driving_score\n1,1,100.0\n1,2,{score}\n", encoding="utf-8")

    keep("planner-alone", 50.0)
    keep("alone", 10.0)
    keep("planner-rules", 49.9)
    keep("rules", 10.0)
    keep("timers", 0.0)
    assert worse(tmp_path) == {"suite/planner-rules": frozenset({"1"})}
    runs = {"runs": [["alone", 1, "7", "S", "T", "Completed", 50.0], ["rules", 1, "7", "S", "T", "Completed", 40.0]]}
    (tmp_path / "b2d.json").write_text(json.dumps(runs), encoding="utf-8")
    assert worse(tmp_path)["b2d/rules"] == frozenset({"7"})
