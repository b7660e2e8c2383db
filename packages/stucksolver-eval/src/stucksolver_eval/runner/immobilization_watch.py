"""Measurements that are the same for every system: immobilizations, and the speed of the traffic."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stucksolver.immobilization import Detector
from stucksolver.scene import Status
from stucksolver.solver import RecoveryWatch
from stucksolver_eval.results.outcome import ImmobilizationEpisode

if TYPE_CHECKING:
    import carla


STOPPED_MPS = 0.1
"""Speed below which the ego counts as stopped, as in the status of a run (m/s)."""


class ImmobilizationWatch:
    """Finds immobilizations with the detector's default settings, independently of the system's own settings."""

    def __init__(self) -> None:
        self._detector = Detector()
        self._watch = RecoveryWatch()
        self._onset: tuple[float, float] | None = None
        self.spells: list[ImmobilizationEpisode] = []
        self.stopped_s = 0.0
        """Time with a speed below `STOPPED_MPS` since the start (s)."""
        self._last_s = 0.0

    def update(self, time_s: float, speed_mps: float, place_m: float) -> None:
        """Update with one tick: time (s), speed (m/s) and position along the route (m)."""
        if speed_mps < STOPPED_MPS:
            self.stopped_s += time_s - self._last_s
        self._last_s = time_s
        status = Status(time_s=time_s, speed_mps=speed_mps, progress_m=place_m)
        trigger = self._detector.update(status)
        slow_s = self._detector.slow_since_s
        was_on = self._watch.active
        self._watch, recovered_after_s = self._watch.advance(status, slow_s, trigger)
        if self._watch.active and not was_on:
            self._onset = (time_s if slow_s is None else slow_s, place_m)
        if recovered_after_s is not None:
            self._close(time_s, recovered_after_s)

    def finish(self, time_s: float) -> None:
        """End an episode that is still open at the end of the route."""
        if self._onset is not None:
            self._close(time_s, None)

    def _close(self, time_s: float, recovered_after_s: float | None) -> None:
        assert self._onset is not None
        onset_s, place_m = self._onset
        after_s = None if recovered_after_s is None else round(recovered_after_s, 3)
        spell = ImmobilizationEpisode(
            onset_s=round(onset_s, 3), place_m=place_m, recovered_after_s=after_s, ended_s=round(time_s, 3)
        )
        self.spells.append(spell)
        self._onset = None


class TrafficSpeeds:
    """Speeds of the background traffic's cars: those with the role `background`."""

    def __init__(self, world: carla.World) -> None:
        self._world = world
        self._known: frozenset[int] = frozenset()
        self._background: list[int] = []

    def read(self, snapshot: carla.WorldSnapshot) -> tuple[float, ...]:
        """Return the speeds of the background vehicles in a snapshot (m/s)."""
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
