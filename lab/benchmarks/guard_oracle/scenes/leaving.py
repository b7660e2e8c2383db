"""The ego has stopped on rails, in a junction, or in another place to keep free, and leaves: back, ahead, or aside."""

from __future__ import annotations

import math
from collections.abc import Callable

from lab.benchmarks.guard_oracle.bodies import Body
from lab.benchmarks.guard_oracle.others import Other, StepsOff, typical_body
from lab.benchmarks.guard_oracle.road import Road
from lab.benchmarks.guard_oracle.scene import Drawn, Setting, brakes, crossing, driving, scene_class, standing
from lab.benchmarks.guard_oracle.scenes.usual import EGO_S, K, pose, road
from lab.benchmarks.guard_oracle.vehicle import LENGTH_M
from stucksolver.plan.behaviors import BackUp, Behavior, ChangeLane, Creep, KeepLane, Wait
from stucksolver.scene import ZoneKind

LENGTHS_M = {
    ZoneKind.LEVEL_CROSSING: (10.0, 36.0),
    ZoneKind.JUNCTION: (7.0, 24.0),
    ZoneKind.CROSSWALK: (3.0, 6.0),
    ZoneKind.KEEP_CLEAR: (8.0, 20.0),
}
"""Shortest and longest places (m)."""
MOST_BACK_M = 40.0
"""Longest way that the ego backs up (m)."""
BLOCKED_M = 2.5
"""Distance from the ego's body within which no vehicle drives across (m): it has stopped for the ego. Ours."""


@scene_class("leaves a place to keep free", block=5)
def leaving(draw: Drawn) -> Setting:
    """Return a scene with the ego in such a place. The exit may be blocked, and others come from all sides."""
    kind = draw.choice(list(LENGTHS_M))
    length = draw.uniform(*LENGTHS_M[kind])
    # The body touches the place at one end at least.
    start = EGO_S - draw.uniform(-LENGTH_M / 2 + 0.2, length + LENGTH_M / 2 - 0.2)
    street = road(draw, draw.choice(["two_way", "multi", "multi"]), bends=0.15, zones=[(kind, start, start + length)])
    setting = Setting(street, behind_m=draw.choice([30.0, 60.0, 100.0]))
    nose = EGO_S + LENGTH_M / 2
    if draw.random() < 0.7:
        _add_leader(draw, setting, nose)
    _add_behind(draw, setting)
    _add_across(draw, setting, kind, start, length)
    setting.propose = _proposals(EGO_S - LENGTH_M / 2, nose, start, start + length)
    return pose(draw, setting, moving=0.0, askew=0.3)


def _add_leader(draw: Drawn, setting: Setting, nose: float) -> None:
    """Add a vehicle ahead that stays, or that sets off and leaves the exit free."""
    kind = draw.choice([K.CAR, K.VAN, K.BUS])
    car = driving("lead", setting.road, 0.0, draw.uniform(-0.4, 0.3), 0.0, "queues", kind)
    car.s = nose + draw.uniform(1.5, 12.0) + car.body.length / 2
    car.stood = draw.uniform(2.0, 60.0)
    if draw.random() < 0.3:
        car.sets_off_at, car.cruise = draw.uniform(0.5, 12.0), draw.uniform(1.0, 6.0)
    setting.others.append(car)


def _add_behind(draw: Drawn, setting: Setting) -> None:
    """Add somebody behind the ego: stopped, following, walking across, or nobody."""
    what, street, tail = draw.random(), setting.road, EGO_S - LENGTH_M / 2
    if what < 0.2:
        kind = draw.choice([K.CAR, K.VAN, K.TRUCK, K.BICYCLE])
        other = standing("behind", street, tail - draw.uniform(4.0, 40.0), draw.uniform(-0.6, 0.6), kind)
        setting.others.append(other)
    elif what < 0.5:
        s, kind = EGO_S - draw.uniform(12.0, 68.0), draw.choice([K.CAR, K.CAR, K.MOTORCYCLE, K.BICYCLE])
        v = draw.uniform(1.0, 6.0 if kind is K.BICYCLE else 12.0)
        setting.others.append(driving("behind", street, s, draw.uniform(-0.8, 0.8), v, "follows us", kind))
    elif what < 0.75:
        side = draw.choice([-1, 1])
        s, d = tail - draw.uniform(1.0, 36.0), side * draw.uniform(2.5, 12.0)
        pace, brakes_at = draw.uniform(0.6, 1.6), draw.choice([math.inf, draw.uniform(0.5, 8.0)])
        walker = crossing("walker", street, s, d, -side * math.pi / 2, pace, "walks", K.PEDESTRIAN, brakes_at=brakes_at)
        setting.others.append(walker)
    if draw.random() < 0.3:
        lane = street.lanes[1]
        way = -1 if lane.name == "oncoming" else 1
        s = EGO_S + way * -1 * draw.uniform(10.0, 60.0)
        role = "comes the other way" if way < 0 else "comes up in the lane entered"
        v = draw.uniform(3.0, 12.0)
        setting.others.append(driving("beside", street, s, lane.offset, v, role, way=way, **brakes(draw)))


def _add_across(draw: Drawn, setting: Setting, kind: ZoneKind, start: float, length: float) -> None:
    """Add what such a place is kept free for: a train, crossing vehicles, or pedestrians; gates beside the rails."""
    street, middle = setting.road, start + length / 2
    side = draw.choice([-1.0, 1.0])
    turn = -side * math.pi / 2
    if kind is ZoneKind.LEVEL_CROSSING:
        for name, s, d in (("gate", start - 2.0, -1.0), ("gate beyond", start + length + 2.0, 1.0)):
            if draw.random() < 0.6 and abs(s - EGO_S) > LENGTH_M / 2 + 1.0:
                setting.others.append(_gate(draw, street, name, s, d))
        if draw.random() < 0.4:
            size, v = (40.0, 2.7, 3.6), draw.uniform(6.0, 12.0)
            far = side * draw.uniform(60.0, 160.0)
            setting.others.append(crossing("train", street, middle, far, turn, v, "train", K.UNKNOWN, size))
    elif kind is ZoneKind.JUNCTION:
        for k in range(draw.choice([0, 1, 1, 2])):
            s = start + length * (0.25 if side > 0 else 0.75) + draw.uniform(-1.0, 1.0)
            if abs(s - EGO_S) < LENGTH_M / 2 + BLOCKED_M:
                continue
            far, v = side * draw.uniform(20.0, 90.0), draw.uniform(3.0, 12.0)
            who = draw.choice([K.CAR, K.CAR, K.VAN, K.MOTORCYCLE, K.BICYCLE])
            setting.others.append(crossing(f"crosser{k}", street, s, far, turn, v, "crosses", who))
            side, turn = -side, -turn
    elif draw.random() < 0.6:
        body, height = typical_body(K.PEDESTRIAN)
        walker = StepsOff("walker 2", K.PEDESTRIAN, body, height, "steps off")
        walker.s, walker.d = draw.uniform(start, start + length), -draw.uniform(2.2, 4.0)
        walker.pace, walker.trigger = draw.uniform(0.6, 1.4), draw.uniform(1.0, 6.0)
        setting.others.append(walker)


def _gate(draw: Drawn, street: Road, name: str, s: float, beside: float) -> Other:
    """Return a closed gate beside the ego's lane, or with its boom across it."""
    gate = standing(name, street, s, 0.0, K.BARRIER)
    boom = draw.random() < 0.3
    x, y, heading = street.point_at(s, beside * (2.0 if boom else 4.5))
    gate.kind, gate.body = K.CROSSING_GATE, Body(x, y, heading, 0.2, 3.5 if boom else 1.0)
    return gate


def _proposals(tail: float, nose: float, start: float, end: float) -> Callable[[Drawn], list[Behavior]]:
    """Return behaviors that leave the place, most of them just; some end a little short of that."""
    back, ahead = nose - start, end - tail

    def propose(again: Drawn) -> list[Behavior]:
        what, more = again.random(), again.choice([again.uniform(0.2, 1.5), again.uniform(-3.0, 6.0)])
        if what < 0.5:
            way = min(max(back + more, 1.0), MOST_BACK_M)
            first = BackUp(distance_m=way, speed_mps=again.uniform(0.6, 2.2))
            return [first] if again.random() < 0.8 else [first, Wait(duration_s=again.uniform(1.0, 3.0))]
        if what < 0.65:
            return [Creep(distance_m=min(max(ahead + more, 1.0), 15.0), speed_mps=again.uniform(0.6, 2.2))]
        if what < 0.85:
            return [KeepLane(distance_m=max(ahead + more, 1.0), speed_mps=again.uniform(0.8, 5.5))]
        way = min(max(ahead + again.uniform(5.0, 20.0), 15.0), 60.0)
        return [ChangeLane(side="left", distance_m=way, speed_mps=again.uniform(1.0, 5.5))]

    return propose
