"""AllWayStopDeadlock."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.deadlock import Deadlock
from stucksolver_eval.scenarios.registry import scenario


@scenario
class AllWayStopDeadlock(Deadlock):
    """Four cars at an all-way stop wait for each other, one with its nose in the hero's way, until somebody creeps."""

    type = "AllWayStopDeadlock"
    expected = "recover"
    suspends = frozenset({"blocked"})
