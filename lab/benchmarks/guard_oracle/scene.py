"""A scene of the oracle (road, others, controls, initial state of the ego) and the registry of scene classes."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

from lab.benchmarks.guard_oracle.bodies import Body
from lab.benchmarks.guard_oracle.others import AlongLane, Other, StepsOff, Straight, typical_body
from lab.benchmarks.guard_oracle.road import Road
from stucksolver.plan.behaviors import Behavior
from stucksolver.scene import ControlKind, LightState, ObjectKind

Drawn = random.Random


@dataclass
class Control:
    """A light or sign at arc length `line`, visible from `seen_from` meters before it.

    A light shows `first` until `changes_at` (s), and `then` afterward.
    """

    kind: ControlKind
    line: float
    first: LightState | None = None
    then: LightState | None = None
    changes_at: float = math.inf
    seen_from: float = math.inf

    def state(self, t: float) -> LightState | None:
        return self.then if t >= self.changes_at else self.first


@dataclass
class Setting:
    """The state of all parts of a scene when a plan is proposed."""

    road: Road
    others: list[Other] = field(default_factory=list)
    walls: list[tuple[Body, float]] = field(default_factory=list)
    """Occluders that are not objects, such as houses and hedges, with their heights (m)."""
    controls: list[Control] = field(default_factory=list)
    ego_s: float = 60.0
    """Arc length of the ego (m)."""
    ego_d: float = 0.0
    """Offset of the ego to the left (m)."""
    ego_yaw: float = 0.0
    """Heading of the ego relative to the road (rad)."""
    ego_speed: float = 0.0
    """Speed of the ego (m/s)."""
    ahead_m: float = 120.0
    """Length of the road ahead in the report (m)."""
    behind_m: float = 60.0
    """Length of the road behind in the report (m)."""
    reach_m: float | None = None
    """Distance up to which objects are visible (m); None: the sight ahead, at least 60 m."""
    stopped_s: float = 25.0
    """Time for which the ego has been stopped (s)."""
    propose: Callable[[Drawn], list[Behavior]] | None = None
    """Random proposals that suit the class, in addition to the general ones."""


DirectedSide = Literal["left", "right"]
SIDES: tuple[DirectedSide, DirectedSide] = ("left", "right")
Maker = Callable[[Drawn], Setting]
CLASSES: dict[str, Maker] = {}
"""The first classes. They share the numbers below `BLOCK` in turn."""
LATER: dict[str, tuple[int, Maker]] = {}
"""Classes that were added later, each with the number of its block. A new class leaves all numbers unchanged."""
BLOCK = 1_000_000
"""Number of scenes per block. The scenes of block k have the numbers from k * BLOCK on."""


def scene_class(name: str, block: int | None = None) -> Callable[[Maker], Maker]:
    """Register a class of scenes, with a block of numbers of its own unless it is one of the first classes.

    Raises:
        ValueError: The name or the block is taken.
    """

    def register(maker: Maker) -> Maker:
        if name in all_classes():
            raise ValueError(f"two classes of scenes are called {name!r}")
        if block is None:
            CLASSES[name] = maker
        elif block < 1 or block in {taken for taken, _ in LATER.values()}:
            raise ValueError(f"{name!r}: block {block} is taken; choose a new one, at least 1")
        else:
            LATER[name] = (block, maker)
        return maker

    return register


def all_classes() -> tuple[str, ...]:
    """Return the names of all classes, the first ones first."""
    return (*CLASSES, *LATER)


def number_of(name: str, k: int) -> int:
    """Return the number of scene `k` of a class."""
    if name in LATER:
        return LATER[name][0] * BLOCK + k
    return k * len(CLASSES) + list(CLASSES).index(name)


def class_of(number: int) -> tuple[str, Maker]:
    """Return name and maker of the class to which a scene's number belongs."""
    block, _ = divmod(number, BLOCK)
    if block:
        return next((name, maker) for name, (own, maker) in LATER.items() if own == block)
    return list(CLASSES.items())[number % len(CLASSES)]


def standing(
    name: str, road: Road, s: float, d: float, kind: ObjectKind = ObjectKind.CAR, *, turn: float = 0.0, role: str = ""
) -> Other:
    """Return a stopped object on the road, at an angle to its direction."""
    body, height = typical_body(kind)
    x, y, heading = road.point_at(s, d)
    body.x, body.y, body.yaw = x, y, heading + turn
    return Other(name, kind, body, height, role or "standing")


def driving(
    name: str,
    road: Road,
    s: float,
    d: float,
    v: float,
    role: str,
    kind: ObjectKind = ObjectKind.CAR,
    *,
    way: int = 1,
    **more: Any,
) -> AlongLane:
    """Return a road user that moves along a lane of the road."""
    body, height = typical_body(kind)
    inside = next((lane for lane in road.lanes if lane.right_m <= d <= lane.left_m), None)
    lane = (inside.right_m, inside.left_m) if inside else (d - 1.75, d + 1.75)
    return AlongLane(name, kind, body, height, role, s=s, d=d, v=v, way=way, lane=lane, **more)


def crossing(
    name: str,
    road: Road,
    s: float,
    d: float,
    turn: float,
    v: float,
    role: str,
    kind: ObjectKind = ObjectKind.CAR,
    size: tuple[float, float, float] | None = None,
    **more: Any,
) -> Straight:
    """Return a road user next to the road that moves straight, at an angle to it."""
    body, height = typical_body(kind, size)
    x, y, heading = road.point_at(s, d)
    body.x, body.y = x, y
    return Straight(name, kind, body, height, role, heading=heading + turn, v=v, **more)


def at_the_kerb(name: str, s: float, d: float, trigger: float, pace: float = 1.4, *, height: float = 1.7) -> StepsOff:
    """Return a pedestrian that may step off the curb."""
    body, _ = typical_body(ObjectKind.PEDESTRIAN)
    return StepsOff(name, ObjectKind.PEDESTRIAN, body, height, "steps off", s=s, d=d, trigger=trigger, pace=pace)


def brakes(draw: Drawn, share: float = 0.4) -> dict[str, Any]:
    """Return time and deceleration of a braking without a reason; in most cases there is none."""
    if draw.random() > share:
        return {}
    return {"brakes_at": draw.uniform(0.0, 10.0), "brakes_by": draw.uniform(0.5, 3.5)}
