"""A recorded drive: the world at its start and the directive of every tick.

It can be driven again, also with changes.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from lab.benchmarks.guard_oracle.bodies import Body
from lab.benchmarks.guard_oracle.others import AlongLane, Other
from lab.benchmarks.guard_oracle.world import ANSWERS_S, HARD_MPS2, World
from stucksolver.plan import Directive


@dataclass(frozen=True)
class Frame:
    """The ego and one other at one tick.

    `t` in s; `ego`, `other`: their bodies; `ego_speed`, `other_speed` in m/s; `ego_d`, `other_d`: their offsets to the
    left of the road's line (m). `visible`: the other is in sight. `abreast`: the other, in a lane of the ego's
    direction, has come as far as the ego's rear. `stops_behind`: it could still stop behind the ego.
    """

    t: float
    ego: Body
    ego_speed: float
    ego_d: float
    other: Body
    other_speed: float
    other_d: float
    visible: bool
    abreast: bool = False
    stops_behind: bool = False


class Recording:
    """A drive. `silent_from`: time from which the solver was silent (s)."""

    def __init__(self, world: World, silent_from: float = math.inf) -> None:
        self.start = copied(world)
        self.silent_from = silent_from
        self.orders: list[Directive] = []

    def worlds(self, *, follows: bool = False, more: int = 0) -> Iterator[World]:
        """Yield the world at every tick, the start included. It is one object that changes.

        `follows`: the vehicle keeps its distance to a lead vehicle. `more`: further ticks, under the last directive.
        """
        world = copied(self.start)
        if follows:
            world.ego.manner = replace(world.ego.manner, follows=True)
        yield world
        for order in self.orders + self.orders[-1:] * more:
            world.step(order)
            yield world

    def frames(self, name: str) -> list[Frame]:
        """Return the frames of the ego and the other of this name."""
        return [frame_of(world, other_of(world, name)) for world in self.worlds()]


def copied(world: World) -> World:
    """Return a copy that can be driven on without a change to the original. Constant parts are shared."""
    new = copy.copy(world)
    new.ego = world.ego.copied()
    new.others = [copy.copy(other) for other in world.others]
    for other in new.others:
        other.body = copy.copy(other.body)
    new.setting = replace(world.setting, others=new.others)
    new.through = set(world.through)
    return new


def other_of(world: World, name: str) -> Other:
    """Return the other with this name."""
    return next(other for other in world.others if other.name == name)


def frame_of(world: World, other: Other) -> Frame:
    """Return the frame of the present tick."""
    ego, body = world.ego_body(), replace(other.body)
    s, d = world.road.find(ego.x, ego.y, world.ego_s)
    _, other_d = world.road.find(body.x, body.y, s)
    frame = Frame(world.t, ego, world.ego.speed, d, body, other.speed, other_d, world.sees(other))
    if not isinstance(other, AlongLane) or other.way < 0:
        return frame
    rear = world.ego_span()[0]
    stop_m = other.v * ANSWERS_S + other.v**2 / (2 * HARD_MPS2)
    return replace(frame, abreast=other.front > rear, stops_behind=other.front < rear - stop_m)
