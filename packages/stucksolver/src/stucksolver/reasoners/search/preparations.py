"""Moves that prepare a plan: back up for room, aside or forward for sight, the nose out for a shorter gap."""

from __future__ import annotations

import math
from collections.abc import Iterator

from stucksolver.plan.assessment import PlanAssessment
from stucksolver.plan.behaviors import REGISTRY, Behavior
from stucksolver.reasoners.search.behavior_grid import on_grid
from stucksolver.scene import AttemptOutcome, Scene
from stucksolver.scene.own_path import own_path_ahead

Steps = tuple[Behavior, ...]

BACK_M = (1.0, 2.0, 4.0, 8.0, 16.0, 30.0)
"""Distances to back up (m): the room for a tighter turn, and the distance from which more of the road is visible."""
LEAST_BACK_M = (1.0, 4.0, 8.0)
"""Least distance to back up, after no, one and more plans with a preparation that were aborted (m): their estimate of
the room was too tight. Ours.
"""
FORWARD_M = (2.0, 5.0, 10.0)
"""Distances to creep forward (m)."""
SHORT_OF_M = (1.5, 3.0)
"""Distances to keep from the object ahead when the ego creeps up to it (m)."""
ASIDE_M, ASIDE_WAY_M = (0.4, 0.8), 6.0
"""Lateral shifts within the lane, and the distance for them (m)."""
SLOW_MPS = 1.5
"""Speed of these moves (m/s)."""
SAFETY_M = (0.0, 0.5, 1.0)
"""Added to the room that is missing (m)."""


def preparations(scene: Scene, assessment: PlanAssessment) -> Iterator[Steps]:
    """Yield moves to put before a refused plan, the smallest first.

    Args:
        scene: The scene.
        assessment: Assessment of the plan that is refused. The room that it misses is tried first.
    """
    backs = _of(scene, "reverse", distance_m=_back_m(scene, assessment), speed_mps=(SLOW_MPS,))
    aside = _of(scene, "aside", distance_m=(ASIDE_WAY_M,), speed_mps=(SLOW_MPS,), offset_m=ASIDE_M)
    noses = _of(scene, "nose", speed_mps=(SLOW_MPS,))
    forward = _of(scene, "creep", distance_m=_forward_m(scene), speed_mps=(SLOW_MPS,))
    singles = [*backs, *noses, *aside, *forward]
    yield from ((item,) for item in singles)
    yield from ((back, nose) for back in backs for nose in noses)
    yield from ((back, move) for back in backs for move in aside)


def moves_for_shorter_gap(scene: Scene) -> Iterator[Steps]:
    """Yield moves to put before a plan that waits for traffic, after which a shorter gap is enough."""
    noses = _of(scene, "nose", speed_mps=(SLOW_MPS,))
    backs = _of(scene, "reverse", distance_m=BACK_M, speed_mps=(SLOW_MPS,))
    yield from ((nose,) for nose in noses)
    yield from ((back, nose) for back in backs for nose in noses)


def _of(scene: Scene, role: str, **fixed: tuple[float, ...]) -> list[Behavior]:
    """Return the offered behaviors of a role on the grid of these values."""
    found: list[Behavior] = []
    for item in scene.behaviors:
        kind = REGISTRY.get(item.name)
        if kind is not None and _role(kind) == role:
            known = {name: values for name, values in fixed.items() if name in kind.model_fields}
            found += on_grid(scene, kind, **known)
    return found


def _role(kind: type[Behavior]) -> str | None:
    """Return how a behavior prepares another one, or None: the registry says what it does, not what it is called."""
    if kind.prepares and kind.reverse:
        return "reverse"
    if kind.prepares and kind.shifts_laterally:
        return "aside" if kind.intents else "nose"
    stops = "stopping_place" in {check.value for check in kind.checks}
    return "creep" if stops and kind.stays_behind_blocker and not kind.reverse else None


def half_way(scene: Scene) -> tuple[tuple[str, ...], ...]:
    """Return the names of the behaviors of plans that began with a preparation and were aborted."""
    aborted = (a.behaviors for a in scene.attempts if a.ended is AttemptOutcome.ABORTED)
    return tuple(names for names in aborted if len(names) > 1 and names[0] in REGISTRY and REGISTRY[names[0]].prepares)


def _back_m(scene: Scene, assessment: PlanAssessment) -> tuple[float, ...]:
    """Return distances to back up: first the room that is missing, then others; more after a plan that failed."""
    missing = [item.missing for item in assessment.shortfalls if item.unit == "m" and item.missing is not None]
    wanted = [max(missing) + more for more in SAFETY_M] if missing else []
    least_m = LEAST_BACK_M[min(len(half_way(scene)), len(LEAST_BACK_M) - 1)]
    ways = (math.ceil(2.0 * max(way, least_m)) / 2.0 for way in wanted if way <= BACK_M[-1])
    return tuple(dict.fromkeys((*ways, *(way for way in BACK_M if way >= least_m))))


def _forward_m(scene: Scene) -> tuple[float, ...]:
    """Return distances to creep: fixed ones, and up to the objects ahead."""
    up_to = [(o.gap_m or 0.0) - short for o in own_path_ahead(scene)[:2] for short in SHORT_OF_M]
    return tuple(dict.fromkeys(round(way, 1) for way in (*(way for way in up_to if way >= 1.0), *FORWARD_M)))
