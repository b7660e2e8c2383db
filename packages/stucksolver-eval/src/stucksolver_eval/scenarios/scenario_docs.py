"""Writes docs/scenarios.md from the classes: `python -m stucksolver_eval.scenarios.scenario_docs [--check]`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from stucksolver_eval.scenarios.families.reported import ReportedScenario
from stucksolver_eval.scenarios.parameters import Parameter, parameters_of
from stucksolver_eval.scenarios.registry import SCENARIOS, load_all
from stucksolver_eval.scenarios.scenario import Scenario

SHOWN = ("ParkedCarInLane", "SlowCyclists", "OpenDoorInLane", "PeopleAtRedLight")
PAGE = Path(__file__).parents[5] / "docs" / "scenarios.md"

_INTRODUCTION = """# Scenario types

The 44 types of CARLA's leaderboard, under their public names and with their public parameters, using only the `carla`
client API. This page is generated from the classes by `python -m stucksolver_eval.scenarios.scenario_docs`.

* A type is one small file in `stucksolver_eval/scenarios/types`: the situation, its trigger, and a script that reads
  from top to bottom, with one `yield` per tick. Shared code is in `stucksolver_eval/scenarios/families`.
* A scenario starts when the hero's position on its route is less than 2 m before the trigger point. Actors that appear
  later wait below the ground until then.
* "Limit" is the time after which the scenario counts as failed. While a type with a limit runs, the test for being
  blocked is suspended, as in the public benchmark. Without a limit, a hero that stands for a minute is blocked.
* If a map or blueprint library lacks what a type needs, the type is unsupported there, with the reason; nothing
  replaces it.
* Sides are those of right-hand traffic. On a map with left-hand traffic (OpenDRIVE's `rule="LHT"`) all of them are
  mirrored: the right is the side of the road's edge.
* The same seed, map and hero give the same run.
* "Driver alone" is what happened to the driver without recovery (`behavior:normal`, seed 1) on a shipped route of the
  type, as seen in the replay. In types about being stuck it is stuck; in types that test the driver's own skill it may
  pass or collide.

## Traffic

The run itself drives the cars of scenarios and of the background, not the client's TrafficManager. They use the
Intelligent Driver Model, pure pursuit, stop lines of red and yellow lights, and reservations at junctions, where
conflicting paths are granted one after another. The cars of a flow hold their speed whatever the hero does, until one
of them has touched it; at junctions all others give way to them.

Background traffic has the public benchmark's numbers (two cars ahead and two behind in each lane, 15 m apart; cars
ahead slow down to wait for the hero, cars behind catch up; oncoming cars every 40 m from 80 m ahead; on other entries
of a junction, cars spawn 40 m before it) with these differences:

* there are at most 4 cars in each lane of the hero's road, 8 oncoming cars, and 10 at a junction, 6 from each entry;
* the two cars on the exit of a junction wait for the hero like cars ahead do;
* cars that leave a junction by another exit than the hero's drive on and are removed 40 m beyond it, instead of
  stopping there;
* at a junction without lights the order is first come, first served, and the hero has priority; stop and yield signs
  apply only to the hero;
* all traffic uses the hero's speed limit, also on other roads;
* oncoming lanes must belong to the hero's own road in the map: carriageways that are separate roads have none.

"""


def page() -> str:
    """Return the page."""
    load_all()
    return _INTRODUCTION + "\n".join((*_rows(), *_ours(), *_reported(), *_shown())) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Write or check the page. Returns 1 if `--check` finds a difference, else 0."""
    parser = argparse.ArgumentParser(description="Writes docs/scenarios.md.")
    parser.add_argument("--check", action="store_true", help="compare only; do not write")
    if parser.parse_args(arguments).check:
        same = PAGE.read_text("utf-8") == page()
        if not same:
            print(f"{PAGE.name} differs: run `python -m stucksolver_eval.scenarios.scenario_docs`", file=sys.stderr)
        return 0 if same else 1
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
    return 0


def _ours() -> Iterator[str]:
    yield ""
    yield "## Stuck situations of our own, and controls"
    yield ""
    yield "Each states what is right (`recover`, `wait`, `ask` or `reroute`) and which criteria it suspends."
    yield "None has a time limit. Types with blueprints that only carlette has are unsupported on CARLA."
    yield ""
    yield "| type | situation | right | what happens when | needs | suspends | simplified | driver alone |"
    yield "|---|---|---|---|---|---|---|---|"
    for name in sorted(SCENARIOS):
        cls = SCENARIOS[name]
        if cls.expected is not None and not issubclass(cls, ReportedScenario):
            needs = ", ".join(part for part in (cls.needs_map, _blueprints(cls)) if part) or "–"
            off = ", ".join(f"`{suspend}`" for suspend in sorted(cls.suspends)) or "–"
            driver_alone = cls.driver_alone or "–"
            cells = (f"`{name}`", _text(cls), cls.expected, cls.starts, needs, off, cls.simplified or "–", driver_alone)
            yield "| " + " | ".join(" ".join(cell.split()) for cell in cells) + " |"


def _reported() -> Iterator[str]:
    yield ""
    yield "## Situations from public reports"
    yield ""
    yield _REPORTED
    yield ""
    yield "| route | type | situation | right | site | source |"
    yield "|---|---|---|---|---|---|"
    rows = [cls.situation for cls in SCENARIOS.values() if issubclass(cls, ReportedScenario)]
    for row in sorted(rows, key=lambda row: row.id):
        until = f" after {row.free_s:.0f} s" if row.free_s is not None else ""
        right = f"{row.expected} (within {row.within_s:.0f} s{until})"
        yield f"| {row.id} | `{row.name}` | {row.about} | {right} | {row.site} | {row.source} |"


_REPORTED = """The suite `reported`: each type is a row of a table in `scenarios/types/reported`.

The staging is ours: one class, three sites for each type, in different towns where these have suitable places. Times
count from the moment at which the ego has arrived: within 25 m of the place, or as the row says.

* `recover`: the ego passes in time. `leave`: no part of it is left in the place where it may not stop.
* `ask`: the ego calls an operator in time and does not pass. `reroute`: it reaches its destination another way in time.
* `wait`: until going becomes right, after the second time in the table, the ego neither passes nor moves by a plan;
  then it passes in time.

An infraction after the arrival is always wrong. "Common report" names a family of reports where no single one is meant.
A row whose source is "Control of" another looks like it, and going is wrong in it. In rows about perception, driver and
solver get a light that differs from the real one, or that does not exist; criteria and other traffic use the real
world."""


def _shown() -> Iterator[str]:
    yield ""
    yield "## Streets of the demonstration and of the cases"
    yield ""
    yield "`stucksolver demo` and `stucksolver cases` find a place for these on any map, without background traffic."
    yield ""
    yield from _HEAD
    yield from map(_row, (SCENARIOS[name] for name in SHOWN))


_HEAD = (
    "| type | situation | what happens when | parameters (default) | needs | limit | simplified | driver alone |",
    "|---|---|---|---|---|---|---|---|",
)


def _rows() -> Iterator[str]:
    yield "## Types"
    yield ""
    yield from _HEAD
    for name in sorted(SCENARIOS):
        if name not in SHOWN and SCENARIOS[name].expected is None:
            yield _row(SCENARIOS[name])


def _row(cls: type[Scenario]) -> str:
    limit = "–" if cls.timeout_s is None else f"{cls.timeout_s:.0f} s"
    parameters = "<br>".join(map(_parameter, parameters_of(cls))) or "–"
    needs = ", ".join(part for part in (cls.needs_map, _blueprints(cls)) if part) or "–"
    driver_alone = cls.driver_alone or "–"
    cells = (f"`{cls.type}`", _text(cls), cls.starts, parameters, needs, limit, cls.simplified or "–", driver_alone)
    return "| " + " | ".join(" ".join(cell.split()) for cell in cells) + " |"


def _text(cls: type[Scenario]) -> str:
    return (cls.__doc__ or "").strip().split("\n\n")[0]


def _parameter(parameter: Parameter[Any]) -> str:
    default = parameter.default
    if default is None:
        return f"`{parameter.name}` (a position)"
    if isinstance(default, tuple):
        return f"`{parameter.name}` ({default[0]:g} to {default[1]:g} {parameter.unit})"
    if isinstance(default, float):
        return f"`{parameter.name}` ({default:g} {parameter.unit})"
    return f"`{parameter.name}` ({default})"


def _blueprints(cls: type[Scenario]) -> str:
    names = list(cls.blueprints)
    if len(names) > 4:
        return f"`{names[0]}` to `{names[-1]}`"
    return ", ".join(f"`{name}`" for name in names)


if __name__ == "__main__":
    sys.exit(main())
