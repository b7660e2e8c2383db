"""Collisions and near misses of a run, counted by the rules that an evaluation counts by."""

from __future__ import annotations

from collections import Counter
from typing import Any

from stucksolver_eval.criteria.base import Infraction, Moment
from stucksolver_eval.criteria.collision import Collisions
from stucksolver_eval.near_miss import NearMissWatch
from stucksolver_eval.results.outcome import Noted


class Mishaps:
    """Call `update` once a tick, `finish` at the end, then `close`. Collisions are Bench2Drive's (`Collisions`)."""

    def __init__(self, world: Any, ego: Any) -> None:
        self._world, self._ego = world, ego
        self._collisions = Collisions(world, ego)
        self._near = NearMissWatch(world, ego)
        self._told = 0, 0

    def update(self, time_s: float) -> list[Infraction | Noted]:
        """What is new at this tick, `time_s` after the start of the run. A collision is told one tick late."""
        frame = int(self._world.get_snapshot().frame)
        moment = Moment(frame, time_s, self._ego.get_transform(), self._ego.get_velocity())
        self._collisions.update(moment)
        self._near.update(time_s, moment.transform, moment.velocity)
        return self._news()

    def finish(self) -> list[Infraction | Noted]:
        """The run is over: what was still on its way."""
        self._collisions.finish()
        return self._news()

    @property
    def counts(self) -> dict[str, int]:
        """By kind, in the words of the leaderboard's record; near misses as `near_miss`."""
        kinds = [one.kind for one in self._collisions.infractions] + [one.kind for one in self._near.found]
        return dict(Counter(kinds))

    @property
    def collisions(self) -> int:
        """Of all kinds."""
        return len(self._collisions.infractions)

    def close(self) -> None:
        self._collisions.close()

    def _news(self) -> list[Infraction | Noted]:
        hits, near = self._told
        self._told = len(self._collisions.infractions), len(self._near.found)
        return [*self._collisions.infractions[hits:], *self._near.found[near:]]
