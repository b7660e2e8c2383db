"""Lead vehicles that the plan swings around: they are slow, set off, or stop during the pass."""

from __future__ import annotations

from typing import Any

from lab.benchmarks.guard_oracle.scene import SIDES, Drawn, Setting, brakes, driving, scene_class
from lab.benchmarks.guard_oracle.scenes.oncoming import borrow
from lab.benchmarks.guard_oracle.scenes.own_direction import change_to
from lab.benchmarks.guard_oracle.scenes.usual import EGO_S, K, pose, road
from stucksolver.plan.behaviors import Behavior, ChangeLane, Nudge, RejoinRoute


def _motion(draw: Drawn) -> tuple[float, dict[str, Any]]:
    """Return the speed of the lead vehicle (m/s), and the times of its braking or setting off."""
    what = draw.random()
    if what < 0.3:
        return draw.uniform(0.3, 4.5), {}
    if what < 0.5:
        return draw.uniform(0.8, 4.5), {"brakes_at": draw.uniform(0.0, 10.0), "brakes_by": draw.uniform(0.5, 3.5)}
    if what < 0.75:
        return 0.0, {"sets_off_at": draw.uniform(0.2, 10.0), "cruise": draw.uniform(0.8, 5.0)}
    stops_at, v = draw.uniform(0.0, 5.0), draw.uniform(0.8, 4.5)
    sets_off_at = stops_at + draw.uniform(1.5, 6.0)
    return v, {"brakes_at": stops_at, "brakes_by": 3.0, "sets_off_at": sets_off_at, "cruise": draw.uniform(v, 5.0)}


@scene_class("leader swung round", block=2)
def swung_round(draw: Drawn) -> Setting:
    """Return a scene with a slow lead vehicle, on one side of the ego's lane or in its middle.

    Other vehicles may be in the lane that the ego uses to pass it.
    """
    street = road(draw, draw.choice(["two_way", "two_way_shoulder", "multi", "right"]))
    kind = draw.choice([K.CAR, K.CAR, K.BICYCLE, K.BICYCLE, K.MOTORCYCLE, K.TRUCK])
    v, motion = _motion(draw)
    aside = draw.uniform(-1.2, 0.5) if kind in (K.BICYCLE, K.MOTORCYCLE) else draw.uniform(-0.6, 0.4)
    lead = driving("lead", street, EGO_S + draw.uniform(7.0, 26.0), aside, v, "leads", kind, **motion)
    lead.stood = draw.uniform(2.0, 60.0) if v == 0.0 else 0.0
    lead.moved_ago = draw.choice([None, lead.stood]) if v == 0.0 else 0.0
    setting = Setting(street, [lead], ahead_m=230.0)
    adjacent_lane = street.lanes[1]
    if draw.random() < 0.4 and adjacent_lane.name != "roadside":
        comes = adjacent_lane.name == "oncoming"
        s = EGO_S + draw.uniform(60.0, 220.0) if comes else EGO_S - draw.uniform(12.0, 60.0)
        role = "comes the other way" if comes else "comes up in the lane entered"
        other_v, way = draw.uniform(3.0, street.limit), -1 if comes else 1
        more = brakes(draw, 0.2)
        setting.others.append(driving("other", street, s, adjacent_lane.offset, other_v, role, way=way, **more))

    def propose(again: Drawn) -> list[Behavior]:
        what = again.random()
        if what < 0.3:
            side = again.choice((*SIDES, SIDES[0]))
            offset, way = again.uniform(0.3, 1.5), again.uniform(4.0, 40.0)
            return [Nudge(side=side, offset_m=offset, distance_m=way, speed_mps=again.uniform(0.8, 5.5))]
        if adjacent_lane.name == "oncoming":
            return borrow(again)
        change = change_to("right" if adjacent_lane.name == "right" else "left")(again)
        if what < 0.5 and isinstance(change[0], ChangeLane):
            return [change[0], RejoinRoute()]
        return change

    setting.propose = propose
    return pose(draw, setting, moving=0.6, askew=0.2)
