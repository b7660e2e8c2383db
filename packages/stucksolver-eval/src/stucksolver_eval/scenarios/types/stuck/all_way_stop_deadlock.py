"""AllWayStopDeadlock."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.deadlock import Deadlock
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.stuck_sites import all_way_stops
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class AllWayStopDeadlock(Deadlock):
    """Four cars at an all-way stop wait for each other, one with its nose in the hero's path, until one creeps."""

    type = "AllWayStopDeadlock"
    placed = SuitePlacement("immobilized", 3100, all_way_stops)
    driver_alone = "stuck before the nose in its path"
    expected = "recover"
    suspends = frozenset({"blocked"})
