"""The shortest way out of a zone in which no vehicle should stop, such as rails, a junction or a crosswalk."""

from __future__ import annotations

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.assessment import PlanAssessor
from stucksolver.plan.behaviors import REGISTRY, Behavior, Check
from stucksolver.reasoners.search.behavior_grid import on_grid
from stucksolver.scene import Scene, ZoneKind

WAYS_M = (3.0, 6.0, 9.0, 12.0, 16.0, 20.0, 25.0, 30.0, 40.0)
"""Distances to try, forward and in reverse (m). Ours; a plan backs up by 40 m at most."""
FAST_MPS, SLOW_MPS = 5.5, 2.2
"""Speeds to try (m/s): that of a recovery, and the fastest in reverse."""


def must_leave(scene: Scene) -> bool:
    """True if the ego has stopped on rails. Whatever it waits for, it must not wait there."""
    return scene.ego.zone is ZoneKind.LEVEL_CROSSING and scene.ego.is_slow


def way_out(scene: Scene, assess: PlanAssessor) -> RecoveryPlan | None:
    """Return the shortest plan that the guard accepts and that ends outside the zone; None if there is none."""
    if scene.ego.zone is None:
        return None
    moves = [behavior for item in scene.behaviors for behavior in _moves(scene, item.name)]
    for behavior in sorted(moves, key=lambda move: move.model_dump()["distance_m"]):
        plan = RecoveryPlan(behaviors=(behavior,))
        assessment = assess(plan)
        if assessment.accepted and assessment.leaves_zone:
            return plan
    return None


def _moves(scene: Scene, name: str) -> list[Behavior]:
    """Return a behavior that drives along the lane on the grid of distances; none for others."""
    kind = REGISTRY.get(name)
    if kind is None or set(kind.model_fields) - {"name"} != {"distance_m", "speed_mps"}:
        return []
    straight = kind.stays_behind_blocker and not kind.shifts_laterally and Check.ROADSIDE not in kind.checks
    return on_grid(scene, kind, distance_m=WAYS_M, speed_mps=(FAST_MPS, SLOW_MPS)) if straight else []
