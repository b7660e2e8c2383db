"""Slow plans through a junction with steady crossing traffic.

At 0.6 to 1.5 m/s the ego is in a crossing lane for up to 12 s. The crossing vehicle comes into sight 50 to 84 m away,
most often when the ego has begun its plan.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from lab.benchmarks.guard_oracle.bodies import Body
from lab.benchmarks.guard_oracle.scene import Drawn, Setting, crossing, scene_class
from lab.benchmarks.guard_oracle.scenes.usual import EGO_S, K, pose, road
from lab.benchmarks.guard_oracle.vehicle import LENGTH_M
from stucksolver.plan.behaviors import Behavior, Creep, KeepLane, Nudge
from stucksolver.scene import ZoneKind

PACES_MPS = (0.6, 1.5)
"""Range of the ego's speeds (m/s)."""
SIGHT_M = (50.0, 84.0)
"""Range of the distances at which the crossing vehicle comes into sight (m)."""
SPEEDS_MPS = (3.0, 13.9)
"""Range of its speeds (m/s)."""
NOSE_S = EGO_S + LENGTH_M / 2
"""Arc length of the ego's front (m)."""
CREEP_M = 15.0
"""Length of the longest creep (m)."""
HALF_CAR_M = 0.95
"""Half the width of a car (m)."""
HOUSE_M = 24.0
"""Length and depth of the house at a corner (m)."""


@scene_class("slow in a junction", block=1)
def slow(draw: Drawn) -> Setting:
    """Return a scene with a junction right ahead, a slow plan, and crossing vehicles that keep their speed."""
    width, start = draw.choice([6.5, 8.0, 14.0]), NOSE_S + draw.uniform(0.3, 3.5)
    street = road(draw, draw.choice(["two_way", "multi"]), bends=0.0, zones=[(ZoneKind.JUNCTION, start, start + width)])
    setting = Setting(street)
    pace = draw.choice([PACES_MPS[1], draw.uniform(*PACES_MPS), draw.uniform(*PACES_MPS)])
    sight_m = draw.uniform(*SIGHT_M)
    from_left = draw.random() < 0.5
    lane_s = start + width * (0.25 if from_left else 0.75)
    meets_s, v = _meets(draw, lane_s, pace, sight_m)
    seen_s = meets_s - sight_m / v
    corner = _house(start, lane_s, sight_m, EGO_S + pace * max(seen_s, 0.0), from_left)
    if corner is not None and draw.random() < 0.5:
        setting.walls.append((corner, 9.0))
    else:
        setting.reach_m = math.hypot(sight_m, lane_s - EGO_S - pace * max(seen_s, 0.0))
    _add_crossers(draw, setting, lane_s, from_left, v, meets_s)
    if draw.random() < 0.3:
        other_s, other_v = start + width * (0.75 if from_left else 0.25), draw.uniform(*SPEEDS_MPS)
        _add_crossers(draw, setting, other_s, not from_left, other_v, meets_s + draw.uniform(-2.0, 6.0))
    setting.propose = _proposals(pace, start + width - NOSE_S)
    pose(draw, setting, moving=0.0, askew=0.2)
    setting.ego_speed = pace if draw.random() < 0.6 else 0.0
    return setting


def _meets(draw: Drawn, lane_s: float, pace: float, sight_m: float) -> tuple[float, float]:
    """Return the time at which the crossing vehicle is at the ego's line (s), and its speed (m/s).

    The ego is in its lane at that time.
    """
    enters_s = (lane_s - HALF_CAR_M - NOSE_S) / pace
    leaves_s = (lane_s + HALF_CAR_M - NOSE_S + LENGTH_M) / pace
    meets_s = draw.uniform(max(enters_s, 2.0) + 0.3, leaves_s + 0.5)
    seen_s = draw.uniform(0.2, max(meets_s - 4.0, 0.3))
    v = sight_m / max(meets_s - seen_s, 1.0)
    return meets_s, min(max(v, SPEEDS_MPS[0]), SPEEDS_MPS[1])


def _house(start: float, lane_s: float, sight_m: float, eye_s: float, on_left: bool) -> Body | None:
    """Return a house that leaves `sight_m` of the crossing lane visible from `eye_s`; None if it does not fit."""
    edge = start - 0.3
    if edge <= eye_s + 0.2:
        return None
    aside = sight_m * (edge - eye_s) / (lane_s - eye_s)
    if not (7.0 if on_left else 3.0) < aside < sight_m:
        return None
    side = 1.0 if on_left else -1.0
    return Body(edge - HOUSE_M / 2, side * (aside + HOUSE_M / 2), 0.0, HOUSE_M, HOUSE_M)


def _add_crossers(draw: Drawn, setting: Setting, s: float, from_left: bool, v: float, meets_s: float) -> None:
    """Add one to three vehicles that follow each other; the first is at the ego's line at `meets_s`."""
    side = 1.0 if from_left else -1.0
    away = v * meets_s
    for _ in range(draw.choice([1, 1, 2, 3])):
        kind = draw.choice([K.CAR, K.CAR, K.CAR, K.VAN, K.TRUCK, K.MOTORCYCLE])
        turn = -side * math.pi / 2
        name = f"crosser{len(setting.others)}"
        setting.others.append(crossing(name, setting.road, s, side * away, turn, v, "crosses", kind))
        away += v * draw.uniform(1.5, 5.0) + 6.0


def _proposals(pace: float, beyond_m: float) -> Callable[[Drawn], list[Behavior]]:
    """Return behaviors that cross the junction at about this pace.

    `beyond_m`: distance from the ego's front to the far side.
    """
    through_m = beyond_m + LENGTH_M + 0.5

    def propose(again: Drawn) -> list[Behavior]:
        what, speed_mps = again.random(), min(max(pace * again.uniform(0.95, 1.1), 0.6), PACES_MPS[1])
        if what < 0.4 and through_m < CREEP_M:
            creep_m = again.uniform(through_m, CREEP_M)
            if again.random() < 0.5:
                return [Creep(distance_m=creep_m)]
            return [Creep(distance_m=creep_m, speed_mps=speed_mps)]
        length_m = through_m + again.uniform(0.0, 12.0)
        if what < 0.85:
            return [KeepLane(distance_m=length_m, speed_mps=speed_mps)]
        aside_m, length_m = again.uniform(0.2, 0.5), min(length_m, 40.0)
        return [Nudge(side="left", offset_m=aside_m, distance_m=length_m, speed_mps=max(speed_mps, 0.6))]

    return propose
