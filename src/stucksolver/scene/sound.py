"""Checks once, on entry, whether the surroundings are plausible, so that later code can rely on every number."""

from __future__ import annotations

import math
from collections.abc import Iterator

from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.surroundings import Surroundings

FURTHEST_M = 1e6
"""Upper bound for positions in a local frame (m)."""
LONGEST_M = 60.0
"""Upper bound for lengths of objects (m)."""
QUICKEST_MPS = 120.0
"""Upper bound for speeds (m/s)."""
OLDEST_S = 1e6
"""Upper bound for ages (s)."""
MOST_OBJECTS = 2000
"""Upper bound for the number of objects."""


def why_unsound(surroundings: Surroundings) -> str | None:
    """Return what is implausible in the surroundings, in a few words, or None.

    It checks for numbers that are not finite or far out of bounds, and for duplicate ids. The models refuse most of
    these when they are created; this also covers copies and objects created without validation.
    """
    return next(_faults(surroundings), None)


def _faults(seen: Surroundings) -> Iterator[str]:
    ego, limits = seen.ego, seen.ego.limits
    if not 0.0 <= seen.age_s <= OLDEST_S or not math.isfinite(seen.time_s):
        yield f"age {seen.age_s} s at {seen.time_s} s"
    if not _within(ego.x_m, ego.y_m, ego.yaw_rad) or not abs(ego.speed_mps) <= QUICKEST_MPS:
        yield "the ego's pose or speed"
    if not (0.0 < ego.length_m <= LONGEST_M and 0.0 < ego.width_m <= LONGEST_M):
        yield "the ego's size"
    if not 0.0 <= (ego.position_sd_m or 0.0) <= LONGEST_M:
        yield "the uncertainty of the ego's position"
    for name in type(limits).model_fields:
        limit = getattr(limits, name)
        if limit is not None and not 0.05 <= limit <= 100.0:
            yield f"the vehicle's {name}"
    if len(seen.objects) > MOST_OBJECTS:
        yield f"{len(seen.objects)} objects"
    if len({o.id for o in seen.objects}) < len(seen.objects):
        yield "two objects with the same id"
    yield from (f"object {o.id}" for o in seen.objects if not _is_sound(o))
    for control in seen.controls:
        if not _within(control.distance_m):
            yield f"the distance of a {control.kind.value}"
    for sight in seen.sight:
        if not (0.0 <= sight.ahead_m <= FURTHEST_M and 0.0 <= sight.behind_m <= FURTHEST_M):
            yield f"the sight of lane {sight.lane_id}"


def _is_sound(o: TrackedObject) -> bool:
    sizes = 0.0 < o.length_m <= LONGEST_M and 0.0 < o.width_m <= LONGEST_M and 0.0 < o.height_m <= LONGEST_M
    moves = abs(o.vx_mps) <= QUICKEST_MPS and abs(o.vy_mps) <= QUICKEST_MPS
    known = (o.stationary_s, o.moved_s_ago, o.seen_for_s)
    ages = all(age is None or 0.0 <= age <= OLDEST_S for age in known)
    sure = o.kind_confidence is None or 0.0 <= o.kind_confidence <= 1.0
    sure &= all(sd is None or 0.0 <= sd <= LONGEST_M for sd in (o.position_sd_m, o.across_sd_m))
    return sizes and moves and ages and sure and _within(o.x_m, o.y_m, o.yaw_rad)


def _within(*values: float) -> bool:
    return all(abs(value) <= FURTHEST_M for value in values)
