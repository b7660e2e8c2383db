"""Writes docs/scenarios.md from the classes: `python -m stucksolver_eval.scenarios.document [--check]`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from stucksolver_eval.scenarios.base import Scenario
from stucksolver_eval.scenarios.parameters import Parameter, parameters_of
from stucksolver_eval.scenarios.registry import SCENARIOS, load_all

SHOWN = ("ParkedCarInLane", "SlowCyclists", "OpenDoorInLane", "PeopleAtRedLight")
PAGE = Path(__file__).parents[3] / "docs" / "scenarios.md"

_INTRODUCTION = """# Scenario types

The 44 types of CARLA's leaderboard, by their public names, with their public parameters, over the `carla` client API
alone. This page is written from the classes by `python -m stucksolver_eval.scenarios.document`.

* A type is one small file in `stucksolver_eval/scenarios/types`: what the situation is, when it is triggered, and a
  script that reads from top to bottom, one `yield` a tick. What types share is in `stucksolver_eval/scenarios/actions`.
* A scenario begins when the hero's place on its route is less than 2 m before the trigger point. What comes later waits
  below the ground until then.
* "Limit" is the time after which the scenario counts as failed; while such a type runs, the test for being blocked is
  off, as in the public benchmark. Where there is none, a hero that stands for a minute is blocked.
* A map or blueprint library that lacks what a type needs makes it unsupported, with the reason; nothing is put in its
  place.
* The same seed, map and hero give the same run.
* "Driver alone" is what became of the driver without recovery (`behavior:normal`, seed 1) on a shipped route of the
  type, as seen in the replay. Where a type is about being stuck it is stuck; where it tests the driver's own skill it
  may pass or collide.

## Traffic

Cars of scenarios and of the background are driven by the run itself, not by the client's TrafficManager: Intelligent
Driver Model, pure pursuit, stop lines of red and yellow lights, and junctions in which ways that meet are given out one
after the other. A flow's cars hold their speed whatever the hero does, until one of them has touched it; at
junctions all others let them by.

Background traffic has the public benchmark's numbers (two cars ahead and two behind in each lane, 15 m apart; cars
ahead slow down to wait for the hero, cars behind hurry; oncoming cars every 40 m from 80 m ahead; other entries of a
junction feed cars from 40 m up) with these differences:

* at most 4 cars in each lane of the hero's road, 8 oncoming ones, and 10 at a junction, at most 6 from each entry;
* the two cars on the exit of a junction wait for the hero like cars ahead do;
* cars that leave a junction by another exit than the hero's drive on and are taken away 40 m beyond it, instead of
  stopping there;
* who cuts across whom at a junction without lights is first come, first served, and the hero before all others;
  stop and yield signs bind nobody else;
* all traffic goes by the hero's speed limit, also on other roads;
* an oncoming lane belongs to the hero's own road in the map: carriageways that are roads of their own have none.

"""


def page() -> str:
    """The whole page."""
    load_all()
    return _INTRODUCTION + "\n".join((*_rows(), *_ours(), *_shown())) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Runs the script; 1 when `--check` finds a difference."""
    parser = argparse.ArgumentParser(description="Writes docs/scenarios.md.")
    parser.add_argument("--check", action="store_true", help="compare, do not write")
    if parser.parse_args(arguments).check:
        same = PAGE.read_text("utf-8") == page()
        if not same:
            print(f"{PAGE.name} differs: run `python -m stucksolver_eval.scenarios.document`", file=sys.stderr)
        return 0 if same else 1
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
    return 0


def _ours() -> Iterator[str]:
    yield ""
    yield "## Stuck situations of our own, and controls"
    yield ""
    yield "Each states what is right (`recover`, `wait`, `ask` or `reroute`) and which criteria are off meanwhile."
    yield "None has a time limit of its own. The types that use blueprints of carlette's own are unsupported on CARLA."
    yield ""
    yield "| type | situation | right | what happens when | needs | suspends | simplified | driver alone |"
    yield "|---|---|---|---|---|---|---|---|"
    for name in sorted(SCENARIOS):
        cls = SCENARIOS[name]
        if cls.expected is not None:
            needs = ", ".join(part for part in (cls.needs_map, _blueprints(cls)) if part) or "–"
            off = ", ".join(f"`{one}`" for one in sorted(cls.suspends)) or "–"
            seen = cls.driver_alone or "–"
            cells = (f"`{name}`", _text(cls), cls.expected, cls.starts, needs, off, cls.simplified or "–", seen)
            yield "| " + " | ".join(" ".join(cell.split()) for cell in cells) + " |"


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
    seen = cls.driver_alone or "–"
    cells = (f"`{cls.type}`", _text(cls), cls.starts, parameters, needs, limit, cls.simplified or "–", seen)
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
