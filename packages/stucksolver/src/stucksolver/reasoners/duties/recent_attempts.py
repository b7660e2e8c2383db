"""What was tried recently."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stucksolver.scene import FailedAttempt, PlanFailure, RejectCode, Scene, SceneObject

REMEMBERED_S = 30.0


def has_been_tried(scene: Scene, name: str) -> bool:
    """True if a plan with this behavior failed in the last `REMEMBERED_S`."""
    return any(name in attempt.behaviors for attempt in recent(scene))


def failed_for(scene: Scene, *why: RejectCode | PlanFailure) -> bool:
    """True if a plan was refused or given up for one of these reasons in the last `REMEMBERED_S`."""
    return any(item in (*attempt.codes, *attempt.failures) for attempt in recent(scene) for item in why)


def often_failed_for(scene: Scene, least: int, *why: RejectCode | PlanFailure) -> bool:
    """True if at least this many plans of the last half minute were refused or given up for one of these reasons."""
    return sum(not set(why).isdisjoint((*a.codes, *a.failures)) for a in recent(scene)) >= least


def came_too_near(scene: Scene, objects: Sequence[SceneObject]) -> bool:
    """True if a plan of the last `REMEMBERED_S` did not keep the required gap to one of these objects.

    In sensor mode the gap to any object counts, because an object that is lost and found again has another id.
    """
    ids = {o.id for o in objects}
    sensed = any(o.position_sd_m for o in objects)
    return any((sensed and RejectCode.GAP in a.codes) or not ids.isdisjoint(a.too_near) for a in recent(scene))


def recent(scene: Scene) -> Iterator[FailedAttempt]:
    """Return the attempts of the last `REMEMBERED_S`."""
    return (a for a in scene.attempts if scene.time_s - a.time_s < REMEMBERED_S)
