"""Changing lights, signs that come into view, and rails."""

from __future__ import annotations

import math

from lab.benchmarks.guard_oracle.scene import SIDES, Control, Drawn, Setting, crossing, driving, scene_class
from lab.benchmarks.guard_oracle.scenes.usual import EGO_S, K, pose, road
from stucksolver.plan.behaviors import Behavior, Creep, KeepLane, Nudge
from stucksolver.scene import ControlKind, LightState, ZoneKind

L = LightState


def straight_behaviors(draw: Drawn) -> list[Behavior]:
    """Return random behaviors that drive straight ahead, some of them far."""
    what = draw.random()
    if what < 0.7:
        return [KeepLane(distance_m=draw.uniform(5.0, 60.0), speed_mps=draw.uniform(1.0, 5.5))]
    if what < 0.85:
        return [Creep(distance_m=draw.uniform(1.0, 15.0))]
    return [Nudge(side=draw.choice(SIDES), offset_m=draw.uniform(0.2, 0.8), distance_m=draw.uniform(4.0, 30.0))]


@scene_class("light that changes")
def light(draw: Drawn) -> Setting:
    """Return a scene in which a green light turns yellow, red or dark during a plan; then a vehicle crosses."""
    line = EGO_S + 2.45 + draw.uniform(1.0, 30.0)
    start = line + draw.uniform(1.0, 4.0)
    street = road(draw, draw.choice(["two_way", "multi"]), bends=0.0, zones=[(ZoneKind.JUNCTION, start, start + 14.0)])
    setting = Setting(street, propose=straight_behaviors)
    then = draw.choice([L.RED, L.YELLOW, L.OFF, L.OFF, L.UNKNOWN])
    changes = draw.uniform(0.1, 8.0)
    setting.controls.append(Control(ControlKind.TRAFFIC_LIGHT, line, L.GREEN, then, changes))
    if draw.random() < 0.6:
        from_left = draw.random() < 0.5
        d = (1 if from_left else -1) * draw.uniform(25.0, 90.0)
        turn = -math.pi / 2 if from_left else math.pi / 2
        v = draw.uniform(4.0, 13.0)
        setting.others.append(crossing("crosser", street, start + 5.0, d, turn, v, "crosses"))
    return pose(draw, setting, moving=0.6, askew=0.2)


@scene_class("stop sign comes into sight")
def stop_sign(draw: Drawn) -> Setting:
    """Return a scene with a sign or a dark light that is only visible from close by."""
    line = EGO_S + 2.45 + draw.uniform(2.0, 35.0)
    start = line + draw.uniform(1.0, 4.0)
    street = road(draw, "two_way", bends=0.0, zones=[(ZoneKind.JUNCTION, start, start + 14.0)])
    setting = Setting(street, propose=straight_behaviors)
    near = draw.uniform(3.0, 30.0)
    if draw.random() < 0.6:
        setting.controls.append(Control(ControlKind.STOP_SIGN, line, seen_from=near))
    else:
        setting.controls.append(Control(ControlKind.TRAFFIC_LIGHT, line, L.OFF, seen_from=near))
    return pose(draw, setting, moving=0.6, askew=0.2)


@scene_class("rails")
def rails(draw: Drawn) -> Setting:
    """Return a scene with a level crossing ahead of or under the ego.

    A train may come. The road beyond may be occupied.
    """
    start = EGO_S + draw.uniform(-5.0, 18.0)
    zones = [(ZoneKind.LEVEL_CROSSING, start, start + 7.0)]
    street = road(draw, draw.choice(["two_way", "multi"]), bends=0.0, zones=zones)
    setting = Setting(street, propose=straight_behaviors)
    if draw.random() < 0.5:
        from_left = draw.random() < 0.5
        d = (1 if from_left else -1) * draw.uniform(60.0, 110.0)
        turn = -math.pi / 2 if from_left else math.pi / 2
        size = (40.0, 2.7, 3.6)
        v = draw.uniform(6.0, 12.0)
        setting.others.append(crossing("train", street, start + 3.5, d, turn, v, "train", K.UNKNOWN, size))
    if draw.random() < 0.5:
        s = max(start + 7.0 + draw.uniform(2.0, 10.0), EGO_S + 8.0)
        setting.others.append(driving("leader", street, s, 0.0, draw.uniform(0.0, 3.0), "leads"))
    return pose(draw, setting, moving=0.4, askew=0.2)
