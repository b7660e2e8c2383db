"""AllWayStopDeadlock."""

from __future__ import annotations

from stucksolver_eval.scenarios.actions.deadlock import Deadlock
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.placed import Placed
from stucksolver_eval.sites.special import all_way_stops


@scenario
class AllWayStopDeadlock(Deadlock):
    """Four cars at an all-way stop wait for each other, one with its nose in the hero's path, until somebody creeps."""

    type = "AllWayStopDeadlock"
    placed = Placed("immobilized", 3100, all_way_stops)
    driver_alone = "stuck before the nose in its path"
    expected = "recover"
    suspends = frozenset({"blocked"})
