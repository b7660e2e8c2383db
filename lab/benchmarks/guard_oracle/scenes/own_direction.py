"""Traffic in the ego's direction: abreast, behind, ahead, filtering past, or in an adjacent traffic flow."""

from __future__ import annotations

from collections.abc import Callable

from lab.benchmarks.guard_oracle.scene import SIDES, DirectedSide, Drawn, Setting, brakes, driving, scene_class
from lab.benchmarks.guard_oracle.scenes.usual import EGO_S, K, blocker, pose, road
from stucksolver.plan.behaviors import Behavior, ChangeLane, KeepLane, Nudge, PullOver, RejoinRoute


def change_to(side: DirectedSide) -> Callable[[Drawn], list[Behavior]]:
    """Return random behaviors that change to an adjacent lane."""

    def change(draw: Drawn) -> list[Behavior]:
        return [ChangeLane(side=side, distance_m=draw.uniform(15.0, 60.0), speed_mps=draw.uniform(1.0, 5.5))]

    return change


@scene_class("beside a stream")
def beside_a_stream(draw: Drawn) -> Setting:
    """Return a scene with a stationary object in the ego's lane, and a queue at one speed in the adjacent lane."""
    left = draw.random() < 0.6
    on = road(draw, draw.choice(["multi", "both"]) if left else "right")
    lane = on.lane("left" if left else "right")
    setting = Setting(on, [blocker(draw, on)], propose=change_to("left" if left else "right"))
    speed, s = draw.uniform(2.0, 13.0), EGO_S - draw.uniform(8.0, 60.0)
    answers = draw.choice(["lane", "lane", "way"])
    headway = draw.uniform(1.0, 3.5) * speed + 5.0
    slows = brakes(draw, 0.2)
    for k in range(draw.randint(1, 3)):
        kind = draw.choice([K.CAR, K.CAR, K.VAN, K.MOTORCYCLE, K.BICYCLE])
        d = lane.offset + draw.uniform(-0.5, 0.5)
        v = min(speed, 7.0) if kind is K.BICYCLE else speed
        role = "comes up in the lane entered"
        setting.others.append(driving(f"stream{k}", on, s, d, v, role, kind, answers=answers, **slows))
        s += headway
    setting.behind_m = draw.choice([60.0, 60.0, 45.0, 30.0])
    return pose(draw, setting)


@scene_class("abreast")
def abreast(draw: Drawn) -> Setting:
    """Return a scene with a road user next to the ego, just ahead or just behind.

    It is in the adjacent lane or at the roadside.
    """
    layout = draw.choice(["multi", "right", "two_way_shoulder", "multi_shoulder"])
    on = road(draw, layout)
    lane = on.lane("roadside" if layout.endswith("shoulder") else ("left" if layout == "multi" else "right"))
    kinds = [K.BICYCLE, K.MOTORCYCLE] if lane.name == "roadside" else [K.CAR, K.VAN, K.TRUCK, K.MOTORCYCLE, K.BICYCLE]
    setting = Setting(on)
    if draw.random() < 0.5:
        setting.others.append(blocker(draw, on))
    for k in range(draw.randint(1, 2)):
        kind = draw.choice(kinds)
        s, v = EGO_S + draw.uniform(-14.0, 12.0) - 12.0 * k, draw.uniform(0.8, 8.0)
        d = lane.offset + draw.uniform(-0.4, 0.4)
        answers = draw.choice(["lane", "way"])
        setting.others.append(
            driving(f"beside{k}", on, s, d, v, "goes beside us", kind, answers=answers, **brakes(draw))
        )

    def propose(again: Drawn) -> list[Behavior]:
        if again.random() < 0.5:
            return change_to("right" if layout == "right" else "left")(again)
        return [PullOver(distance_m=again.uniform(10.0, 40.0), speed_mps=again.uniform(1.0, 5.0))]

    setting.propose = propose
    return pose(draw, setting, moving=0.5)


@scene_class("cyclist filters")
def filters(draw: Drawn) -> Setting:
    """Return a scene in which two-wheelers pass the ego within its lane or next to it."""
    on = road(draw, draw.choice(["two_way", "two_way_shoulder", "multi", "two_way_parking"]))
    setting = Setting(on)
    if draw.random() < 0.6:
        setting.others.append(blocker(draw, on))
    pose(draw, setting, moving=0.4)
    for k in range(draw.randint(1, 2)):
        side = draw.choice([-1, -1, 1])
        d = setting.ego_d + side * draw.uniform(1.3, 2.4)
        kind = draw.choice([K.BICYCLE, K.BICYCLE, K.MOTORCYCLE])
        s = EGO_S - draw.uniform(-4.0, 25.0) - 8.0 * k
        setting.others.append(
            driving(
                f"bike{k}",
                on,
                s,
                d,
                draw.uniform(1.5, 7.0),
                "filters past us",
                kind,
                answers="way",
                **brakes(draw, 0.2),
            )
        )

    def propose(again: Drawn) -> list[Behavior]:
        what = again.random()
        if what < 0.4:
            side = again.choice(SIDES)
            offset, way = again.uniform(0.2, 1.2), again.uniform(4.0, 30.0)
            return [Nudge(side=side, offset_m=offset, distance_m=way, speed_mps=again.uniform(0.8, 4.0))]
        if what < 0.7:
            return [PullOver(distance_m=again.uniform(10.0, 40.0), speed_mps=again.uniform(1.0, 5.0))]
        return [RejoinRoute()] if what < 0.8 else [KeepLane(distance_m=again.uniform(5.0, 40.0), speed_mps=4.0)]

    setting.propose = propose
    return setting


@scene_class("leader")
def leader(draw: Drawn) -> Setting:
    """Return a scene with a lead vehicle that may brake; a follower may approach from behind."""
    on = road(draw, draw.choice(["two_way", "multi"]))
    kind = draw.choice([K.CAR, K.CAR, K.BUS, K.BICYCLE])
    v = draw.uniform(1.0, 9.0)
    ahead = driving(
        "leader", on, EGO_S + draw.uniform(10.0, 35.0), draw.uniform(-0.4, 0.4), v, "leads", kind, **brakes(draw)
    )
    setting = Setting(on, [ahead])
    if draw.random() < 0.4:
        behind = driving("follower", on, EGO_S - draw.uniform(15.0, 40.0), 0.0, draw.uniform(1.0, 6.0), "follows us")
        setting.others.append(behind)
    return pose(draw, setting, moving=0.7)
