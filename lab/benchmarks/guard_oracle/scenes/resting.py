"""Objects that have been stationary for some time, in the ego's path or next to it, and then move off."""

from __future__ import annotations

import math
from typing import Any

from lab.benchmarks.guard_oracle.others import Other
from lab.benchmarks.guard_oracle.road import Road
from lab.benchmarks.guard_oracle.scene import SIDES, Drawn, Setting, crossing, driving, scene_class
from lab.benchmarks.guard_oracle.scenes.oncoming import borrow
from lab.benchmarks.guard_oracle.scenes.usual import EGO_S, K, pose, road
from stucksolver.plan.behaviors import Behavior, Creep, KeepLane, Nudge
from stucksolver.scene import ZoneKind


def _rests(draw: Drawn, other: Other) -> Other:
    """Set the time for which it has been stationary, and whether it moved before that."""
    other.stood = draw.choice([draw.uniform(0.0, 5.0), draw.uniform(5.0, 70.0)])
    other.moved_ago = draw.choice([None, other.stood])
    return other


def _at_the_line(draw: Drawn, street: Road, start: float, width: float) -> list[Other]:
    """Return vehicles that wait at the crossing road's lines; some come up to the line and wait there first."""
    found: list[Other] = []
    for from_left in draw.choice([(True,), (False,), (True, False)]):
        side = 1.0 if from_left else -1.0
        s = start + width * (0.25 if from_left else 0.75)
        kind = draw.choice([K.CAR, K.CAR, K.VAN, K.MOTORCYCLE, K.BICYCLE])
        away = (5.8 if from_left else 2.4) + draw.uniform(2.5, 6.0)
        cruise = draw.uniform(1.0, 4.5 if kind is K.BICYCLE else 8.0)
        arrives = draw.random() < 0.5
        v, brakes_by = (draw.uniform(2.0, 6.0), draw.uniform(1.0, 3.0)) if arrives else (0.0, 3.0)
        brakes_at = draw.uniform(0.0, 4.0) if arrives else math.inf
        away += v * brakes_at + v * v / (2 * brakes_by) if arrives else 0.0
        stops_s = brakes_at + v / brakes_by if arrives else 0.0
        more: dict[str, Any] = {"brakes_at": brakes_at, "brakes_by": brakes_by, "cruise": cruise}
        more["sets_off_at"] = stops_s + draw.uniform(0.3, 9.0)
        turn = -side * math.pi / 2
        item = crossing(f"crosser{len(found)}", street, s, side * away, turn, v, "crosses", kind, **more)
        found.append(item if arrives else _rests(draw, item))
    return found


@scene_class("waits at a junction, then moves off", block=3)
def at_a_junction(draw: Drawn) -> Setting:
    """Return a scene in which vehicles wait at a crossing road's lines and set off at any time.

    They may also set off while the ego is in the junction.
    """
    start, width = EGO_S + 2.45 + draw.uniform(0.5, 10.0), draw.choice([7.0, 14.0])
    zones = [(ZoneKind.JUNCTION, start, start + width)]
    street = road(draw, draw.choice(["two_way", "multi"]), bends=0.0, zones=zones)
    setting = Setting(street, _at_the_line(draw, street, start, width))

    def propose(again: Drawn) -> list[Behavior]:
        if again.random() < 0.2:
            return [Creep(distance_m=again.uniform(2.0, 15.0))]
        return [KeepLane(distance_m=width + again.uniform(8.0, 35.0), speed_mps=again.uniform(0.8, 5.5))]

    setting.propose = propose
    return pose(draw, setting, moving=0.5, askew=0.2)


@scene_class("rests on the road, then moves off", block=4)
def on_the_road(draw: Drawn) -> Setting:
    """Return a scene in which a stationary vehicle or two-wheeler, or a waiting pedestrian, moves off.

    A vehicle is in the ego's lane or at its edge.
    """
    street = road(draw, draw.choice(["two_way", "two_way_parking", "two_way_shoulder", "multi"]))
    setting = Setting(street, ahead_m=230.0)
    for k in range(draw.choice([1, 1, 2])):
        name, s, sets_off_at = "lead" if k == 0 else f"rests{k}", EGO_S + draw.uniform(7.5, 30.0), draw.uniform(0.2, 14)
        if draw.random() < 0.3:
            side = draw.choice([-1, 1])
            d = side * draw.uniform(1.6, 4.5) + (1.5 if side > 0 else 0.0)
            turn = draw.choice([0.0, math.pi, -side * math.pi / 2, -side * math.pi / 2])
            pace = draw.uniform(0.6, 1.4)
            more: dict[str, Any] = {"sets_off_at": sets_off_at, "cruise": pace}
            one: Other = crossing(name, street, s, d, turn, 0.0, "walks", K.PEDESTRIAN, **more)
        else:
            kind = draw.choice([K.CAR, K.CAR, K.VAN, K.TRUCK, K.BICYCLE, K.MOTORCYCLE])
            d, cruise = draw.choice([draw.uniform(-0.6, 0.4), draw.uniform(-2.6, -1.4)]), draw.uniform(1.0, 6.0)
            one = driving(name, street, s, d, 0.0, "queues", kind, sets_off_at=sets_off_at, cruise=cruise)
        setting.others.append(_rests(draw, one))

    def propose(again: Drawn) -> list[Behavior]:
        what = again.random()
        if what < 0.45:
            return borrow(again)
        if what < 0.75:
            side, offset = again.choice(SIDES), again.uniform(0.3, 1.5)
            return [
                Nudge(side=side, offset_m=offset, distance_m=again.uniform(4.0, 40), speed_mps=again.uniform(0.8, 4))
            ]
        return [KeepLane(distance_m=again.uniform(4.0, 40.0), speed_mps=again.uniform(0.8, 5.5))]

    setting.propose = propose
    return pose(draw, setting, moving=0.4, askew=0.3)
