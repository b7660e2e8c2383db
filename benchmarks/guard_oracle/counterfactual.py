"""What would have happened otherwise: a stop at another moment, or a stack that keeps its distance to a leader.

Everybody but the ego does what the oracle's models do, as in the recorded drive. The ego's steering goes on along its
last path while it brakes. A stop may end anywhere, also with the nose in a junction.
"""

from __future__ import annotations

from dataclasses import replace

from benchmarks.guard_oracle.bodies import distance
from benchmarks.guard_oracle.others import AlongLane, Other, Straight
from benchmarks.guard_oracle.recording import Recording, copied
from benchmarks.guard_oracle.vehicle import STATED_LAG_S
from benchmarks.guard_oracle.world import AT_REST_MPS, DT, LIMITS, World
from stucksolver.decision import Execute
from stucksolver.decision.behaviors import Wait
from stucksolver.scene import ObjectKind

GENTLY_MPS2, HARD_MPS2 = LIMITS.comfort_braking_mps2, LIMITS.max_braking_mps2
"""The decelerations that the vehicle states (assumption A9)."""
WATCHED_S = 3.0
"""A stop is watched for this long after the time of the recorded contact, ..."""
STANDS_S = 5.0
"""... and for this long after the ego has stopped."""
MOST_S = 60.0
SPARE_M = 0.1
"""A stop that leaves less room to somebody who crosses does not count as one that avoids a contact. Ours: places are
known no better, and assumption A3 grants a tracking error 0.15 m.
"""
COARSE = 5
"""Ticks between the stops that are tried first."""


def stop_avoids(world: World, name: str, brake_mps2: float, until_s: float) -> bool:
    """If the ego brakes from now on, does it touch neither the other of this name nor anyone else?

    Pedestrians and traffic from behind who run into an ego that stands do not count, unless it is that other: they keep
    their own distance (assumption A3). The brakes act after any delay up to the one that the vehicle states, so the
    stop must avoid the contact both with that delay and without one, by `SPARE_M`. `until_s`: time up to which the stop
    is watched at least. The world stays as it is.
    """
    return all(_stop_avoids(world, name, brake_mps2, until_s, lag_s) for lag_s in (STATED_LAG_S, 0.0))


def _stop_avoids(world: World, name: str, brake_mps2: float, until_s: float, lag_s: float) -> bool:
    """The same for one delay of the brakes. It has none if the ego is braking already."""
    world = copied(world)
    world.ego.manner = replace(world.ego.manner, lag=lag_s)
    order = Execute(behavior=Wait(duration_s=1.0), brake_mps2=brake_mps2)
    stood_s = 0.0
    while world.t < MOST_S and (stood_s < STANDS_S or world.t < until_s):
        world.step(order)
        rests = abs(world.ego.speed) < AT_REST_MPS
        if any(other.name == name or not (rests and keeps_distance(other)) for other in world.all_touched()):
            return False
        if any(distance(world.ego_body(), other.body, SPARE_M) < SPARE_M for other in world.others if crosses(other)):
            return False
        stood_s = stood_s + DT if rests else 0.0
    return True


def crosses(other: Other) -> bool:
    """Is it somebody who moves, and not along a lane?"""
    return isinstance(other, Straight) and other.speed > AT_REST_MPS


def keeps_distance(other: Other) -> bool:
    """Is it somebody who keeps the distance to a vehicle that stands?"""
    return other.kind is ObjectKind.PEDESTRIAN or (isinstance(other, AlongLane) and other.way > 0)


class Stops:
    """Stops of the ego at the ticks of a recorded drive that ended in a contact with the other of this name."""

    def __init__(self, recording: Recording, name: str) -> None:
        self._name = name
        self._worlds = [copied(world) for world in recording.worlds()]
        self._until_s = self._worlds[-1].t + WATCHED_S
        self._known: dict[int, bool] = {}

    def avoid(self, tick: int) -> bool:
        """Does a stop that begins at this tick, gently or hard, avoid the contact?"""
        if tick not in self._known:
            world = self._worlds[tick]
            self._known[tick] = any(stop_avoids(world, self._name, b, self._until_s) for b in (GENTLY_MPS2, HARD_MPS2))
        return self._known[tick]

    def latest(self, first: int) -> int | None:
        """The latest tick from `first` on at which a stop avoids the contact, to 0.25 s; None if no tick does."""
        last = len(self._worlds) - 2
        for tick in range(last, first - 1, -COARSE):
            if self.avoid(tick):
                return tick
        return next((tick for tick in range(last, first - 1, -1) if self.avoid(tick)), None)


def following_avoids(recording: Recording, name: str) -> bool:
    """If the stack kept its distance to a leader, would the ego touch nobody, and the other not even later on?"""
    until_s = len(recording.orders) * DT
    for world in recording.worlds(follows=True, more=round(WATCHED_S / DT)):
        touched = world.touched()
        if touched is not None and (touched.name == name or world.t <= until_s):
            return False
    return True
