"""The shortest way out of a zone in which no vehicle should stop, such as rails, a junction or a crosswalk."""

from __future__ import annotations

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.assessment import PlanAssessor
from stucksolver.plan.behaviors import REGISTRY, Behavior, Check
from stucksolver.reasoners.search.behavior_grid import on_grid
from stucksolver.scene import Scene, ZoneKind

WAYS_M = (3.0, 6.0, 9.0, 12.0, 16.0, 20.0, 25.0, 30.0, 40.0)
"""Distances to try, forward and in reverse (m). Ours; a plan backs up by 40 m at most."""
SPEEDS_MPS = (5.5, 2.2)
"""Speeds to try (m/s): that of a recovery, and the fastest in reverse."""
LEAVE_S = 10.0
"""Time stopped before the ego leaves a zone other than rails (s). Ours: another road is taken before."""


def must_leave(scene: Scene) -> bool:
    """True if the ego has stopped on rails. Whatever it waits for, it must not wait there."""
    return scene.ego.zone is ZoneKind.LEVEL_CROSSING and scene.ego.is_slow


def may_leave(scene: Scene) -> bool:
    """True if an ego that has stopped in another zone for a while should leave it, since nothing leads on.

    Not again in the same intervention: it came back, so that somebody else must find a way.
    """
    left_before = any(len(attempt.behaviors) == 1 and _is_straight(attempt.behaviors[0]) for attempt in scene.attempts)
    return scene.guidance is None and scene.ego.stopped_for_s >= LEAVE_S and not left_before


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
    if not _is_straight(name):
        return []
    return on_grid(scene, REGISTRY[name], distance_m=WAYS_M, speed_mps=SPEEDS_MPS)


def _is_straight(name: str) -> bool:
    """True for a behavior that only drives a distance along the lane."""
    kind = REGISTRY.get(name)
    if kind is None or set(kind.model_fields) - {"name"} != {"distance_m", "speed_mps"}:
        return False
    return kind.stays_behind_blocker and not kind.shifts_laterally and Check.ROADSIDE not in kind.checks
