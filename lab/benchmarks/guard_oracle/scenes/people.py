"""Pedestrians: visible at the curb, walking or crossing, or hidden by parked vehicles."""

from __future__ import annotations

import math
from typing import Any

from lab.benchmarks.guard_oracle.scene import SIDES, Drawn, Setting, at_the_kerb, crossing, scene_class, standing
from lab.benchmarks.guard_oracle.scenes.usual import EGO_S, K, blocker, pose, road
from stucksolver.plan.behaviors import Behavior, Creep, KeepLane, Nudge, PullOver


def straight_behaviors(draw: Drawn) -> list[Behavior]:
    """Return random behaviors: straight on, fast or slowly, or slightly to the side."""
    what = draw.random()
    if what < 0.5:
        return [KeepLane(distance_m=draw.uniform(8.0, 45.0), speed_mps=draw.uniform(1.0, 5.5))]
    if what < 0.7:
        return [Creep(distance_m=draw.uniform(2.0, 15.0))]
    if what < 0.85:
        return [PullOver(distance_m=draw.uniform(10.0, 40.0), speed_mps=draw.uniform(1.0, 5.0))]
    return [Nudge(side=draw.choice(SIDES), offset_m=draw.uniform(0.2, 1.0), distance_m=draw.uniform(4.0, 30.0))]


@scene_class("people")
def people(draw: Drawn) -> Setting:
    """Return a scene with visible pedestrians: some stand at the curb and step off, some walk along, some cross."""
    street = road(draw, draw.choice(["two_way", "two_way_shoulder", "multi"]))
    setting = Setting(street, propose=straight_behaviors)
    if draw.random() < 0.25:
        setting.others.append(blocker(draw, street))
    for k in range(draw.randint(1, 3)):
        s = EGO_S + draw.uniform(3.0, 40.0)
        side = -1 if draw.random() < 0.7 else 1
        d = side * draw.uniform(2.1, 6.0) + (0.0 if side < 0 else 2.5)
        what = draw.random()
        if what < 0.45:
            setting.others.append(at_the_kerb(f"walker{k}", s, d, draw.uniform(0.0, 14.0)))
            continue
        turn = draw.choice([0.0, math.pi]) if what < 0.65 else -side * math.pi / 2 * draw.uniform(0.7, 1.3)
        stops: dict[str, Any] = {"brakes_at": draw.uniform(0.0, 8.0), "brakes_by": 2.0} if draw.random() < 0.3 else {}
        pace = draw.uniform(0.6, 1.8)
        setting.others.append(crossing(f"walker{k}", street, s, d, turn, pace, "walks", K.PEDESTRIAN, **stops))
    return pose(draw, setting, askew=0.3)


@scene_class("people behind parked cars")
def late(draw: Drawn) -> Setting:
    """Return a scene with parked vehicles on the right; a pedestrian steps out between or in front of them.

    The pedestrian may be as small as a child.
    """
    street = road(draw, "two_way_parking")
    setting = Setting(street, propose=straight_behaviors)
    s = EGO_S + draw.uniform(-4.0, 10.0)
    for k in range(draw.randint(2, 4)):
        kind = draw.choice([K.CAR, K.CAR, K.VAN, K.TRUCK])
        parked = standing(
            f"parked{k}", street, s, -draw.uniform(2.75, 3.1), kind, turn=draw.gauss(0.0, 0.03), role="parked"
        )
        setting.others.append(parked)
        s += parked.body.length / 2 + draw.uniform(0.7, 2.0)
        if draw.random() < 0.7:
            walker = at_the_kerb(f"walker{k}", s, -draw.uniform(3.0, 4.5), draw.uniform(0.0, 12.0))
            walker.height = draw.choice([1.7, 1.1, 1.1])
            walker.role = "steps out from behind a parked vehicle"
            setting.others.append(walker)
        s += draw.uniform(3.2, 5.5)
    return pose(draw, setting, moving=0.5, askew=0.2)
