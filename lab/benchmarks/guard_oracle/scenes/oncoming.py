"""Oncoming traffic, visible or not yet visible, and crossing traffic."""

from __future__ import annotations

import math

from lab.benchmarks.guard_oracle.bodies import Body
from lab.benchmarks.guard_oracle.scene import Drawn, Setting, brakes, crossing, driving, scene_class, standing
from lab.benchmarks.guard_oracle.scenes.usual import EGO_S, K, blocker, pose, road
from stucksolver.plan.behaviors import Behavior, BorrowOncomingLane, Creep, KeepLane, Nudge
from stucksolver.scene import ZoneKind


def borrow(draw: Drawn) -> list[Behavior]:
    """Return random behaviors that use the oncoming lane."""
    quick = draw.random() < 0.2
    return [
        BorrowOncomingLane(
            past_object_id="lead", speed_mps=draw.uniform(5.5, 11.0) if quick else draw.uniform(1.5, 5.5)
        )
    ]


@scene_class("oncoming, seen")
def visible_oncoming(draw: Drawn) -> Setting:
    """Return a scene with a stationary object in the ego's lane and oncoming traffic."""
    on = road(draw, "two_way", bends=0.4)
    lane = on.lane("oncoming")
    slow = driving(
        "lead", on, EGO_S + draw.uniform(8.0, 20.0), draw.uniform(-0.9, 0.3), draw.uniform(1.0, 4.5), "leads", K.BICYCLE
    )
    setting = Setting(on, [slow if draw.random() < 0.25 else blocker(draw, on)], propose=borrow)
    s = EGO_S + draw.uniform(25.0, 220.0)
    for k in range(draw.randint(1, 2)):
        kind = draw.choice([K.CAR, K.CAR, K.TRUCK, K.MOTORCYCLE, K.BICYCLE])
        v, d = draw.uniform(2.0, on.limit), lane.offset + draw.uniform(-0.4, 0.4)
        setting.others.append(driving(f"oncoming{k}", on, s, d, v, "comes the other way", kind, way=-1, **brakes(draw)))
        s += draw.uniform(15.0, 60.0)
    setting.ahead_m = 230.0
    return pose(draw, setting, moving=0.2)


@scene_class("oncoming, not seen yet")
def unseen(draw: Drawn) -> Setting:
    """Return the same with oncoming traffic just out of sight, at the speed limit."""
    on = road(draw, "two_way", bends=0.5)
    lane = on.lane("oncoming")
    setting = Setting(on, [blocker(draw, on)], propose=borrow)
    setting.ahead_m = draw.uniform(20.0, 200.0)
    s = EGO_S + setting.ahead_m + draw.uniform(0.0, 40.0)
    v = on.limit * draw.uniform(0.7, 1.0)
    if draw.random() < 0.3:
        hides = standing("hides", on, EGO_S + draw.uniform(15.0, 40.0), draw.uniform(1.0, 2.2), K.TRUCK)
        setting.others.append(hides)
    setting.others.append(driving("oncoming", on, s, lane.offset, v, "comes the other way", way=-1))
    return pose(draw, setting, moving=0.2)


@scene_class("crossing traffic")
def crossers(draw: Drawn) -> Setting:
    """Return a scene with a junction ahead and vehicles that cross straight, some hidden by a house."""
    start = EGO_S + draw.uniform(1.0, 18.0)
    on = road(draw, draw.choice(["two_way", "multi"]), bends=0.0, zones=[(ZoneKind.JUNCTION, start, start + 14.0)])
    setting = Setting(on)
    if draw.random() < 0.4:
        for side in (-1, 1):
            house = Body(start - 10.0, side * draw.uniform(13.0, 18.0) + 1.75, 0.0, 16.0, 12.0)
            setting.walls.append((house, 9.0))
    for k in range(draw.randint(1, 3)):
        from_left = draw.random() < 0.5
        turn = (-1 if from_left else 1) * (math.pi / 2 + draw.uniform(-0.25, 0.25))
        away = draw.uniform(12.0, 70.0)
        d = away if from_left else -away
        s = start + (4.0 if from_left else 10.0)
        kind = draw.choice([K.CAR, K.CAR, K.TRUCK, K.MOTORCYCLE, K.BICYCLE])
        v = draw.uniform(2.0, 13.0)
        # Vehicles that cross at another angle are moved back along their path, so that they reach the road there.
        s += d / math.tan(turn)
        setting.others.append(crossing(f"crosser{k}", on, s, d, turn, v, "crosses", kind, **brakes(draw, 0.3)))

    def propose(again: Drawn) -> list[Behavior]:
        what = again.random()
        if what < 0.6:
            return [KeepLane(distance_m=again.uniform(10.0, 60.0), speed_mps=again.uniform(1.5, 5.5))]
        if what < 0.8:
            return [Creep(distance_m=again.uniform(1.0, 15.0))]
        return [Nudge(side="left", offset_m=again.uniform(0.2, 0.8), distance_m=again.uniform(4.0, 30.0))]

    setting.propose = propose
    return pose(draw, setting, moving=0.3, askew=0.2)
