"""Groups the behaviours of a plan into the stretches that are proven as one path."""

from __future__ import annotations

from stucksolver.plan.behaviors import Behavior, Check

ALONE = frozenset({Check.CREEP_SPEED, Check.WITHIN_LANE, Check.ROADSIDE, Check.STOPPING_PLACE, Check.TURNING})
"""Behaviours with their own bounds on the whole path are proven separately."""


def segments_of(behaviors: tuple[Behavior, ...]) -> tuple[tuple[Behavior, ...], ...]:
    """Group behaviours that follow each other without a stop, to prove them as one path; the others stay single."""
    segments: list[list[Behavior]] = []
    joined = False
    for behavior in behaviors:
        alone = behavior.stands_still or behavior.reverse or bool(ALONE & set(behavior.checks))
        if joined and not alone:
            segments[-1].append(behavior)
        else:
            segments.append([behavior])
        joined = not alone
    return tuple(map(tuple, segments))
