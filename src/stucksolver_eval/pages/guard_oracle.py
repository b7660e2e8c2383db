"""Writes results/guard_oracle.md: what the oracle's campaigns found.

    python -m stucksolver_eval.pages.guard_oracle                             # of what is kept
    python -m stucksolver_eval.pages.guard_oracle keep OUT/seed-1.jsonl NAME  # keeps a campaign's results first

Campaigns are driven with `python -m benchmarks.guard_oracle`; `refusals.json` is made by
`python -m benchmarks.guard_oracle.refusals`. Run it from the repository's root, with the project's environment.
"""

from __future__ import annotations

import json
import sys
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

from stucksolver_eval.pages import RESULTS

KEPT = RESULTS / "guard_oracle"
ABOUT = """Made by `python -m stucksolver_eval.pages.guard_oracle`. Plans of the rules, and behaviours at random, are
put before the guard in scenes of many classes. What it accepts is driven in closed loop, the guard looking on ten
times a second, by a bicycle with a rear axle that starts up to 0.5 rad askew, drifts up to 1 m beside its path (the
guard ends a plan at 0.9 m), takes up to 0.3 s until its brakes bite, and brakes for nobody but on an order. In 6 % of
the drives the solver falls silent and the lease runs out; in 40 % the stack does not even follow who goes ahead of it.
The others do their worst within the assumptions of [docs/SAFETY.md](../docs/SAFETY.md). Bodies, contacts, sight and
motion are the oracle's own ([benchmarks/guard_oracle](../benchmarks/guard_oracle)); behaviours, `Execution` and
`Lease` are the product's."""
REFUSED = """The same proposals before both guards. Each new refusal is driven with nobody looking on, sluggish and
eager, beside others who answer to what enters their lane or their way: a contact, or somebody who must brake by more
than 3.5 m/s², is harm shown (bold), and so is a body off the road or out of its lane where that was the reason. Where
somebody may come out of what is not seen behind, somebody does, at the limit. No harm shown does not make a refusal
wrong: the guard asks for gaps and for sight."""


def keep(path: Path, name: str) -> None:
    """Keeps what the page needs of a campaign."""
    classes: dict[str, Counter[str]] = defaultdict(Counter)
    ends: Counter[str] = Counter()
    found, scenes, seconds = [], 0, 0.0
    for line in path.read_text(encoding="utf-8").splitlines():
        row = json.loads(line)
        if "scene" not in row:
            scenes += 1
            continue
        counts = classes[row["class"]]
        for what in ("proposed", f"{row['source']} proposed"):
            counts[what] += 1
        counts["accepted"] += row["accepted"]
        counts[f"{row['source']} accepted"] += row["accepted"]
        if row.get("driven"):
            counts["driven"] += 1
            ends[row["end"]] += 1
            seconds += row["t"]
        if "contact" in row:
            counts["contacts" if row["excluded"] else "contacts not excluded"] += 1
        if row.get("missed"):
            counts["lines or rails"] += 1
        if "contact" in row or row.get("missed"):
            found.append({k: v for k, v in row.items() if k not in ("accepted", "driven")})
    data = {
        "scenes": scenes,
        "driven_s": round(seconds),
        "classes": {name: dict(counts) for name, counts in classes.items()},
        "ends": dict(ends),
        "found": found,
    }
    KEPT.mkdir(exist_ok=True)
    (KEPT / f"{name}.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


def campaign_table(data: dict[str, Any]) -> list[str]:
    """One campaign, class by class."""
    rows = [
        "| class of scene | proposed | accepted | of the rules' own | driven | contacts, excluded | not excluded "
        "| lines, rails |",
        "|---|---|---|---|---|---|---|---|",
    ]
    total: Counter[str] = Counter()
    for name, counts in [*data["classes"].items(), ("all", total)]:
        if name != "all":
            total.update(counts)
        get = Counter(counts)
        share = 100 * get["accepted"] / max(get["proposed"], 1)
        rows.append(
            f"| {name} | {get['proposed']} | {get['accepted']} ({share:.0f} %) | {get['rules accepted']} of "
            f"{get['rules proposed']} | {get['driven']} | {get['contacts']} | {get['contacts not excluded']} | "
            f"{get['lines or rails']} |"
        )
    return rows


def found_table(data: dict[str, Any]) -> list[str]:
    """Every contact, and every line passed."""
    if not data["found"]:
        return ["No contact at all."]
    rows = ["| scene, plan | class | behaviours | what | excluded by |", "|---|---|---|---|---|"]
    for row in data["found"]:
        hit = row.get("contact")
        what = ", ".join(row["missed"])
        if hit:
            what = f"{hit['kind']} that {hit['role']}: our {hit['part']}, their {hit['their_part']}"
            what += f", we at {hit['ego_speed']:.1f} m/s"
            what += ", solver silent" if hit["order"] == "silent" else ""
        plan = ", ".join(b["name"] for b in row["plan"])
        why = (row.get("excluded") or "**not excluded**") if hit else "**not excluded**"
        rows.append(f"| {row['scene']}, {row['k']} | {row['class']} | {plan} | {what} | {why} |")
    return rows


def refusal_tables(data: dict[str, Any]) -> list[str]:
    """What is refused that was accepted before."""
    rows = [
        "| class of scene | proposed | accepted before | after | of those before still accepted | newly refused "
        "| of which with harm shown | newly accepted |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, counts in data["counts"].items():
        get = Counter(counts)
        still = 100 * (1 - get["newly refused"] / get["before"]) if get["before"] else 100.0
        rows.append(
            f"| {name} | {get['proposed']} | {get['before']} | {get['after']} | {still:.0f} % "
            f"| {get['newly refused']} | {get['with harm shown']} | {get['newly accepted']} |"
        )
    rows += ["", "| scene, plan | class | behaviours | refused, since | driven all the same |", "|---|---|---|---|---|"]
    for one in data["refused"]:
        came = "; ".join(_came_of(one)) or "nothing"
        came = f"**{came}**" if one["harm"] else came
        names = ", ".join(one["behaviors"])
        rows.append(f"| {one['scene']}, {one['k']} | {one['groups'][0]} | {names} | {one['why']} | {came} |")
    return rows


def _came_of(one: dict[str, Any]) -> list[str]:
    """What came of driving a refused plan all the same."""
    found = [f"contact: {one['contact']}"] if one["contact"] else []
    if one["brakes_mps2"]:
        found.append(f"they brake by {one['brakes_mps2']} m/s²")
    for what, why in (("off_lane_m", "leaves_its_lane"), ("off_road_m", "off_road")):
        if why in one["why"]:
            found.append(f"{one[what]:.1f} m {'out of its lane' if what == 'off_lane_m' else 'off the road'}")
    return found


def page() -> str:
    """The page, of what is kept."""
    parts = ["# What the oracle makes of the guard", "", ABOUT, ""]
    notes = KEPT / "notes.md"
    if notes.exists():
        parts += [notes.read_text(encoding="utf-8").strip(), ""]
    for path in sorted(KEPT.glob("*.json")):
        data = json.loads(path.read_text(encoding="utf-8"))
        if path.stem == "refusals":
            continue
        ends = ", ".join(f"{name} {count}" for name, count in sorted(data["ends"].items(), key=lambda x: -x[1]))
        parts += [
            f"## Driven: {path.stem}",
            "",
            f"{data['scenes']} scenes, {data['driven_s'] / 3600:.1f} h driven. Ends: {ends}.",
            "",
        ]
        parts += [*campaign_table(data), "", *found_table(data), ""]
    refusals = KEPT / "refusals.json"
    if refusals.exists():
        data = json.loads(refusals.read_text(encoding="utf-8"))
        parts += ["## Refused, but accepted by the guard of 711cb94", ""]
        parts += [REFUSED, ""]
        parts += refusal_tables(data)
    return "\n".join(parts).rstrip() + "\n"


def main() -> None:
    """See the module's own words."""
    if len(sys.argv) == 4 and sys.argv[1] == "keep":
        keep(Path(sys.argv[2]), sys.argv[3])
    elif len(sys.argv) > 1:
        raise SystemExit(__doc__)
    (RESULTS / "guard_oracle.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
