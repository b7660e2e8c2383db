"""What is measured of every arm alike: immobilizations, near misses, the speed of the traffic, progress over time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stucksolver.detect import Detector
from stucksolver.evaluate.results.outcome import Noted, Spell
from stucksolver.scene import Status
from stucksolver.scene.boxes import separation
from stucksolver.solver import ProgressWatch
from stucksolver.stacks.driver.perception import Perception, Surroundings

MOVING_MPS = 0.1
NEAR_GAP_M, NEAR_TTC_S = 0.3, 1.0
LOOK_EVERY_S = 0.2
LOOK_RANGE_M = 40.0
_TTC_STEPS_S = (0.0, 0.25, 0.5, 0.75, 1.0)


class SpellWatch:
    """Immobilizations, by the detector with its usual settings, whatever the arm's own are."""

    def __init__(self) -> None:
        self._detector = Detector()
        self._watch = ProgressWatch()
        self._onset: tuple[float, float] | None = None
        self.spells: list[Spell] = []

    def update(self, time_s: float, speed_mps: float, place_m: float) -> None:
        status = Status(time_s=time_s, speed_mps=speed_mps, progress_m=place_m)
        trigger = self._detector.update(status)
        slow_s = self._detector.slow_since_s
        was_on = self._watch.on
        recovered_after_s = self._watch.update(status, slow_s, trigger)
        if self._watch.on and not was_on:
            self._onset = (time_s if slow_s is None else slow_s, place_m)
        if recovered_after_s is not None:
            self._close(time_s, recovered_after_s)

    def finish(self, time_s: float) -> None:
        if self._onset is not None:
            self._close(time_s, None)

    def _close(self, time_s: float, recovered_after_s: float | None) -> None:
        assert self._onset is not None
        onset_s, place_m = self._onset
        spell = Spell(onset_s=onset_s, place_m=place_m, recovered_after_s=recovered_after_s, ended_s=time_s)
        self.spells.append(spell)
        self._onset = None


class NearMissWatch:
    """Gaps below 0.3 m to a moving actor, and contacts less than 1 s away if both go on as they do; each once."""

    def __init__(self, world: Any, ego: Any) -> None:
        self._perception = Perception(world, ego.id, LOOK_RANGE_M)
        box = ego.bounding_box.extent
        self._half = (float(box.x), float(box.y))
        self._next_s = 0.0
        self._near: frozenset[int] = frozenset()
        self.found: list[Noted] = []

    def update(self, time_s: float, transform: Any, velocity: Any) -> None:
        if time_s < self._next_s - 1e-6:
            return
        self._next_s = time_s + LOOK_EVERY_S
        place = transform.location
        seen = self._perception.read(place.x, place.y)
        near = self._near_ones(seen, transform, velocity) if len(seen) else frozenset()
        for actor_id in sorted(near - self._near):
            self.found.append(Noted(kind="near_miss", time_s=round(time_s, 2), text=f"near miss with actor {actor_id}"))
        self._near = near

    def _near_ones(self, seen: Surroundings, transform: Any, velocity: Any) -> frozenset[int]:
        place, yaw = transform.location, math.radians(transform.rotation.yaw)
        moving = np.hypot(seen.vx, seen.vy) > MOVING_MPS
        level = (seen.top > place.z - 1.0) & (seen.bottom < place.z + 2.5)
        rows = np.flatnonzero(moving & level)
        if not len(rows):
            return frozenset()
        times = np.array(_TTC_STEPS_S)[:, None]
        gaps = separation(
            (place.x + velocity.x * times, place.y + velocity.y * times, yaw),
            self._half,
            (seen.x[rows] + seen.vx[rows] * times, seen.y[rows] + seen.vy[rows] * times, seen.yaw[rows]),
            (seen.half_length[rows], seen.half_width[rows]),
        )
        close = (gaps[0] < NEAR_GAP_M) | (gaps[:-1] <= 0.0).any(axis=0)
        return frozenset(seen.actor_id[int(i)] for i in rows[close])


class TrafficSpeeds:
    """Speeds of the background traffic's cars: those with the role `background`."""

    def __init__(self, world: Any) -> None:
        self._world = world
        self._known: frozenset[int] = frozenset()
        self._background: list[int] = []

    def read(self, snapshot: Any) -> tuple[float, ...]:
        ids = frozenset(actor.id for actor in snapshot)
        if ids != self._known:
            self._meet(ids)
        speeds = []
        for actor_id in self._background:
            actor = snapshot.find(actor_id)
            if actor is not None:
                v = actor.get_velocity()
                speeds.append(math.hypot(v.x, v.y))
        return tuple(speeds)

    def _meet(self, ids: frozenset[int]) -> None:
        self._background = [i for i in self._background if i in ids]
        new = ids - self._known
        for actor in self._world.get_actors(sorted(new)):
            vehicle = actor.type_id.startswith("vehicle")
            if vehicle and actor.attributes.get("role_name") == "background":
                self._background.append(actor.id)
        self._background.sort()
        self._known = ids
