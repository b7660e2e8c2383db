"""Stationary traffic: parked cars next to a swing-out, queues, pulling over, and backing up."""

from __future__ import annotations

from lab.benchmarks.guard_oracle.scene import SIDES, Drawn, Setting, brakes, crossing, driving, scene_class, standing
from lab.benchmarks.guard_oracle.scenes.oncoming import borrow
from lab.benchmarks.guard_oracle.scenes.own_direction import change_to
from lab.benchmarks.guard_oracle.scenes.usual import EGO_S, K, blocker, pose, road
from stucksolver.plan.behaviors import BackUp, Behavior, KeepLane, Nudge, PullOver, RejoinRoute


@scene_class("swing-out beside parked cars")
def swing_out(draw: Drawn) -> Setting:
    """Return a narrow scene with an object ahead, and parked vehicles on one side or both."""
    street = road(draw, draw.choice(["two_way_parking", "multi", "two_way"]))
    setting = Setting(street, [blocker(draw, street)])
    far = street.lanes[1].left_m
    for k in range(draw.randint(1, 4)):
        right = draw.random() < 0.6
        d = -draw.uniform(2.1, 3.0) if right else far - draw.uniform(0.2, 1.3)
        s = EGO_S + draw.uniform(-6.0, 35.0)
        kind = draw.choice([K.CAR, K.VAN, K.TRUCK, K.CONE])
        setting.others.append(standing(f"parked{k}", street, s, d, kind, turn=draw.gauss(0.0, 0.08), role="parked"))

    def propose(again: Drawn) -> list[Behavior]:
        what = again.random()
        if what < 0.35:
            return borrow(again)
        if what < 0.5:
            return change_to("left")(again)
        if what < 0.75:
            side = again.choice(SIDES)
            offset, way = again.uniform(0.2, 1.3), again.uniform(4.0, 30.0)
            return [Nudge(side=side, offset_m=offset, distance_m=way, speed_mps=again.uniform(0.8, 4.0))]
        if what < 0.85:
            return [RejoinRoute()]
        return [KeepLane(distance_m=again.uniform(4.0, 40.0), speed_mps=again.uniform(1.0, 5.5))]

    setting.propose = propose
    setting.ahead_m = 230.0
    return pose(draw, setting, moving=0.25, askew=0.7)


@scene_class("queue")
def queue(draw: Drawn) -> Setting:
    """Return a scene with two to four vehicles in a queue ahead; the first starts at some time."""
    street = road(draw, draw.choice(["two_way", "two_way", "multi"]))
    setting = Setting(street, propose=borrow, ahead_m=230.0)
    s, sets_off = EGO_S + 2.45, draw.uniform(0.0, 12.0)
    cars = []
    for k in range(draw.randint(2, 4)):
        kind = draw.choice([K.CAR, K.CAR, K.VAN, K.BUS])
        car = driving("lead" if k == 0 else f"queue{k}", street, 0.0, draw.uniform(-0.35, 0.35), 0.0, "queues", kind)
        s += draw.uniform(2.0, 6.0) + car.body.length / 2
        car.s, car.stood, car.moved_ago = s, draw.uniform(0.0, 70.0), draw.choice([None, None, 0.0, 5.0])
        s += car.body.length / 2
        cars.append(car)
    for k, car in enumerate(reversed(cars)):
        car.sets_off_at = sets_off + 1.2 * k
    setting.others += cars
    if draw.random() < 0.5:
        lane = street.lane("oncoming" if street.lanes[1].name == "oncoming" else "left")
        way = -1 if lane.name == "oncoming" else 1
        place = EGO_S + (draw.uniform(40.0, 220.0) if way < 0 else -draw.uniform(10.0, 50.0))
        role = "comes the other way" if way < 0 else "comes up in the lane entered"
        v = draw.uniform(3.0, 13.0)
        setting.others.append(driving("other", street, place, lane.offset, v, role, way=way, **brakes(draw)))
    return pose(draw, setting, moving=0.2, askew=0.3)


@scene_class("pull-over")
def pull_over(draw: Drawn) -> Setting:
    """Return a scene with space at the roadside, in some scenes with a road user behind or next to the ego there."""
    street = road(draw, draw.choice(["two_way_shoulder", "two_way_parking", "multi_shoulder", "two_way"]))
    setting = Setting(street)
    if draw.random() < 0.5:
        s, d = EGO_S + draw.uniform(12.0, 50.0), -draw.uniform(2.6, 3.1)
        setting.others.append(standing("parked", street, s, d, draw.choice([K.CAR, K.VAN, K.CONE]), role="parked"))
    if draw.random() < 0.6:
        s, d = EGO_S + draw.uniform(-30.0, 8.0), -draw.uniform(1.5, 2.9)
        kind, v = draw.choice([K.BICYCLE, K.BICYCLE, K.MOTORCYCLE]), draw.uniform(1.0, 7.0)
        bike = driving("bike", street, s, d, v, "filters past us", kind, answers="way", **brakes(draw, 0.2))
        setting.others.append(bike)

    def propose(again: Drawn) -> list[Behavior]:
        return [PullOver(distance_m=again.uniform(10.0, 60.0), speed_mps=again.uniform(1.0, 5.5))]

    setting.propose = propose
    return pose(draw, setting, moving=0.6)


@scene_class("backing up")
def back_up(draw: Drawn) -> Setting:
    """Return a scene with an object close ahead. A road user behind the ego is stopped, approaches, or walks across."""
    street = road(draw, draw.choice(["two_way", "multi"]))
    setting = Setting(street, [blocker(draw, street)])
    what = draw.random()
    if what < 0.35:
        gap = draw.uniform(1.0, 14.0)
        kind = draw.choice([K.CAR, K.VAN, K.TRUCK])
        behind = standing("behind", street, EGO_S - 2.45 - gap - 3.0, draw.uniform(-0.4, 0.4), kind)
        setting.others.append(behind)
    elif what < 0.6:
        s = EGO_S - draw.uniform(10.0, 45.0)
        setting.others.append(driving("behind", street, s, 0.0, draw.uniform(1.0, 8.0), "follows us"))
    elif what < 0.85:
        side = draw.choice([-1, 1])
        s, d = EGO_S - 2.45 - draw.uniform(1.0, 10.0), side * draw.uniform(2.5, 7.0)
        pace = draw.uniform(0.6, 1.6)
        setting.others.append(crossing("walker", street, s, d, -side * 1.57, pace, "walks", K.PEDESTRIAN))

    def propose(again: Drawn) -> list[Behavior]:
        first = BackUp(distance_m=again.uniform(1.0, 8.0), speed_mps=again.uniform(0.5, 2.0))
        return [first] if again.random() < 0.6 else [first, *borrow(again)]

    setting.propose = propose
    return pose(draw, setting, moving=0.0, askew=0.3)
