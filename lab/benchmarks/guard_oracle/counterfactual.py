"""Counterfactual drives: a stop at another tick, or a stack that keeps its distance to a lead vehicle.

All road users except the ego act as the oracle's models do, as in the recorded drive. The ego steers along its last
path while it brakes. A stop may end anywhere, also with the nose in a junction.
"""

from __future__ import annotations

import math
from dataclasses import replace

from lab.benchmarks.guard_oracle.bodies import Body, distance
from lab.benchmarks.guard_oracle.drive import EVERY
from lab.benchmarks.guard_oracle.others import AlongLane, Other, Straight
from lab.benchmarks.guard_oracle.recording import Recording, copied, other_of
from lab.benchmarks.guard_oracle.vehicle import STATED_LAG_S
from lab.benchmarks.guard_oracle.world import AT_REST_MPS, DT, LIMITS, World
from stucksolver.plan import Directive, Execute
from stucksolver.plan.behaviors import Wait
from stucksolver.scene import ObjectKind

GENTLY_MPS2, HARD_MPS2 = LIMITS.comfort_braking_mps2, LIMITS.max_braking_mps2
"""Decelerations that the vehicle states (m/s²), as in assumption A9."""
WATCHED_S = 3.0
"""Time after the recorded contact for which a stop is observed (s). Ours."""
STANDS_S = 5.0
"""Time after the stop of the ego for which it is observed (s). Ours."""
MOST_S = 60.0
"""Longest counterfactual drive (s). Ours."""
SPARE_M = 0.1
"""Least space to the crossing vehicle with which a stop counts as avoiding a contact (m).

Ours: positions are no more accurate, and assumption A3 grants a tracking error 0.15 m.
"""
SPARE_S = 0.5
"""Least time to the crossing vehicle with which going on counts as avoiding a contact (s).

Ours: half of the time that SAFETY.md grants to a road user that crosses early.
"""
RESUMES_S = (1.0, 2.5)
"""Times after the recorded contact at which an ego that has yielded goes on (s). Ours."""
COARSE = 5
"""Number of ticks between the stops that are tried first. Ours."""


def stop_avoids(world: World, name: str, brake_mps2: float, contact_s: float, path: Directive | None = None) -> bool:
    """True if the ego, braking from now on, touches neither the other of this name nor any other road user.

    The ego stays stopped for some time after the contact and the stop, or goes on along a path once the other has
    passed. Pedestrians and traffic from behind that run into a stopped ego do not count, except that other: they keep
    their own distance (assumption A3). The brakes act after any delay up to the one that the vehicle states, so the
    stop must avoid the contact both with that delay and without one. The world is not changed.

    Args:
        world: The world when the stop begins.
        name: Name of the other.
        brake_mps2: Deceleration (m/s²).
        contact_s: Time of the recorded contact.
        path: The directive to go on; None if the ego only stops.
    """
    resumes = [math.inf] if path is None else [math.inf, *(contact_s + after_s for after_s in RESUMES_S)]
    return any(
        all(_stop_avoids(world, name, brake_mps2, contact_s, lag_s, path, at_s) for lag_s in (STATED_LAG_S, 0.0))
        for at_s in resumes
    )


def _stop_avoids(
    world: World, name: str, brake_mps2: float, contact_s: float, lag_s: float, path: Directive | None, at_s: float
) -> bool:
    """Return the same for one delay of the brakes and one time of going on.

    There is no delay if the ego brakes already.
    """
    world = copied(world)
    world.ego.manner = replace(world.ego.manner, lag=lag_s)
    order = Execute(behavior=Wait(duration_s=1.0), brake_mps2=brake_mps2)
    stood_s, least_m = 0.0, min(SPARE_M, room_m(world, name))
    while world.t < MOST_S and (stood_s < STANDS_S or world.t < contact_s + WATCHED_S):
        on = path if world.t >= at_s else None
        if on is not None and world.ego.path_is_done:
            break
        world.step(order if on is None else on)
        rests = abs(world.ego.speed) < AT_REST_MPS
        if any(other.name == name or not (rests and keeps_distance(other)) for other in world.all_touched()):
            return False
        if room_m(world, name) < least_m:
            return False
        stood_s = stood_s + DT if rests else 0.0
    return True


def going_on_avoids(world: World, name: str, order: Directive, contact_s: float) -> bool:
    """True if the ego, going on along a path from now on, as the directive ordered, touches no road user.

    It needs some time to spare: the other is not near within `SPARE_S` before or after the ego is there.
    """
    world = copied(world)
    way: list[tuple[Body, Body]] = []
    while world.t < contact_s + WATCHED_S and not world.ego.path_is_done:
        world.step(order)
        if next(world.all_touched(), None) is not None:
            return False
        way.append((world.ego_body(), replace(other_of(world, name).body)))
    spare = round(SPARE_S / DT)
    apart = ((ego, way[k][1]) for at, (ego, _) in enumerate(way) for k in (at - spare, at + spare) if 0 <= k < len(way))
    return bool(way) and not any(ego.within(other, 0.0) and distance(ego, other) <= 0.0 for ego, other in apart)


def keeps_distance(other: Other) -> bool:
    """True if a road user keeps the distance to a stopped vehicle."""
    return other.kind is ObjectKind.PEDESTRIAN or (isinstance(other, AlongLane) and other.way > 0)


def room_m(world: World, name: str) -> float:
    """Return the gap to a crossing vehicle of this name (m), at most `SPARE_M`."""
    other = other_of(world, name)
    crosses = isinstance(other, Straight) and other.kind is not ObjectKind.PEDESTRIAN
    return distance(world.ego_body(), other.body, SPARE_M) if crosses else SPARE_M


class Stops:
    """Alternatives of the ego in a recorded drive that ended in a contact with the other of this name.

    It could have stopped, at each tick, or gone on along its path.
    """

    def __init__(self, recording: Recording, name: str) -> None:
        self._name = name
        self._worlds = [copied(world) for world in recording.worlds()]
        self._contact_s = self._worlds[-1].t
        self._known: dict[int, bool] = {}
        self._orders = recording.orders

    def avoid(self, tick: int) -> bool:
        """True if a stop that begins at this tick, gentle or hard, avoids the contact."""
        if tick not in self._known:
            world = self._worlds[tick]
            levels = (GENTLY_MPS2, HARD_MPS2)
            path = self._path_until(tick + 1)
            self._known[tick] = any(stop_avoids(world, self._name, b, self._contact_s, path) for b in levels)
        return self._known[tick]

    def latest(self, first: int) -> int | None:
        """Return the latest tick from `first` on at which a stop avoids the contact, to 0.25 s; None without one."""
        last = len(self._worlds) - 2
        for tick in range(last, first - 1, -COARSE):
            if self.avoid(tick):
                return tick
        looks = range(last - last % EVERY, first - 1, -EVERY)
        return next((tick for tick in looks if self.avoid(tick)), None)

    def going_on_avoids(self, first: int) -> bool:
        """True if the ego stopped from this tick on, and would have had no contact if it had gone on."""
        stops = next((k for k in range(first, len(self._orders)) if not _goes_on(self._orders[k])), None)
        path = self._path_until(stops)
        if path is None or stops is None:
            return False
        return going_on_avoids(self._worlds[stops], self._name, path, self._contact_s)

    def _path_until(self, tick: int | None) -> Directive | None:
        """Return the last directive before this tick to drive along a path; None if there was none."""
        return next((order for order in reversed(self._orders[:tick]) if _goes_on(order)), None)


def _goes_on(order: Directive) -> bool:
    return isinstance(order, Execute) and bool(order.path)


def following_avoids(recording: Recording, name: str) -> bool:
    """True if the ego, with a stack that keeps its distance, touches no road user, and the other not even later on."""
    until_s = len(recording.orders) * DT
    for world in recording.worlds(follows=True, more=round(WATCHED_S / DT)):
        touched = world.touched()
        if touched is not None and (touched.name == name or world.t <= until_s):
            return False
    return True
