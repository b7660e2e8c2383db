"""Draws the utterances for routes of the shipped suites, by seed and scenario type.

```sh
python -m stucksolver_eval.guidance.assignment   # rewrites suites/data/guidance-*.json; the result is always the same
```

About 15 % of each suite's routes are drawn, independently of the results of drives.
"""

from __future__ import annotations

import json
import math
from random import Random

from stucksolver_eval.guidance.catalog import HELPS, GuidanceKind
from stucksolver_eval.guidance.script import Script, ScriptLine
from stucksolver_eval.routes import Route
from stucksolver_eval.suites import DATA, suite

SUITES = ("bench220", "dev", "immobilized")
SEED = 24
"""Seed of the draw. Ours."""


def draw_script(name: str, seed: int = SEED) -> Script:
    """Return the script of a suite. Raises `ValueError` if it has too few routes for a kind of help."""
    left = {route.id: route for route in suite(name).routes}
    random = Random(f"{name}:{seed}")
    found: dict[str, tuple[ScriptLine, ...]] = {}
    for help in HELPS:
        wanted = help.routes.get(name, 0)
        fitting = [
            id for id, route in sorted(left.items()) if route.scenarios and route.scenarios[0].type in help.types
        ]
        if len(fitting) < wanted:
            raise ValueError(f"{name} has {len(fitting)} routes left for {help.name!r}; {wanted} are needed")
        for route_id in random.sample(fitting, wanted):
            found[route_id] = _lines(help, left.pop(route_id))
    return Script(routes=dict(sorted(found.items())))


def _lines(kind: GuidanceKind, route: Route) -> tuple[ScriptLine, ...]:
    """Return the lines for a route; with `at_trigger`, positions count from the scenario's trigger."""
    if not kind.at_trigger:
        return kind.lines
    begin_m = _trigger_m(route)
    moved = [line.when.model_copy(update={"place_m": begin_m + (line.when.place_m or 0.0)}) for line in kind.lines]
    return tuple(line.model_copy(update={"when": when}) for line, when in zip(kind.lines, moved, strict=True))


def _trigger_m(route: Route) -> float:
    """Return the approximate start of the first scenario on the route (m). Routes are nearly straight up to there."""
    start, trigger = route.waypoints[0], route.scenarios[0].trigger.position
    return round(math.dist((start.x_m, start.y_m), (trigger.x_m, trigger.y_m)), 1)


def main() -> None:
    """Write the scripts."""
    for name in SUITES:
        lines = draw_script(name).model_dump(mode="json", exclude_none=True, exclude_defaults=True)
        text = json.dumps({"version": 1, **lines}, indent=1) + "\n"
        (DATA / f"guidance-{name}.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
