"""What is measured while a run goes on: completion, standing still, collisions, near misses, recovery."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stucksolver.detect import Detector, Trigger
from stucksolver.scene import Status, TrackedObject
from stucksolver.scene.boxes import separation
from stucksolver.scene.surroundings import EgoState
from stucksolver.solver import ProgressWatch

STANDING_MPS = 0.1
BLOCKED_S = 60.0
NEAR_MISS_M = 0.3
SAME_EVENT_S = 5.0


class CollisionWatch:
    """A collision sensor on the ego, counted as Bench2Drive counts: by whom, and not twice for one contact."""

    def __init__(self, world: Any, ego: Any) -> None:
        import carla

        blueprint = world.get_blueprint_library().find("sensor.other.collision")
        self._sensor = world.spawn_actor(blueprint, carla.Transform(), attach_to=ego)
        self._last: dict[int, float] = {}
        self.counts: dict[str, int] = {}
        self.news: list[str] = []
        self._sensor.listen(self._hit)

    def _hit(self, event: Any) -> None:
        other, now = event.other_actor, float(event.timestamp)
        since = now - self._last.get(other.id, -1e9)
        self._last[other.id] = now
        if since < SAME_EVENT_S:
            return
        kind = _collision_kind(other.type_id)
        self.counts[kind] = self.counts.get(kind, 0) + 1
        self.news.append(f"collision with {other.type_id}")

    @property
    def touched(self) -> int:
        """How many different actors."""
        return len(self._last)

    def close(self) -> None:
        self._sensor.stop()
        self._sensor.destroy()


def _collision_kind(type_id: str) -> str:
    for part, kind in (("walker", "collision_pedestrian"), ("vehicle", "collision_vehicle")):
        if part in type_id:
            return kind
    return "collision_layout"


@dataclass
class Measures:
    """Figures of one run, updated tick by tick from the stack's own status."""

    length_m: float
    start_m: float
    detector: Detector = field(default_factory=Detector)
    standing_s: float = 0.0
    standing_run_s: float = 0.0
    stuck: list[tuple[float, float]] = field(default_factory=list)
    watch: ProgressWatch = field(default_factory=ProgressWatch)
    immobilizations: int = 0
    recovery_times_s: list[float] = field(default_factory=list)
    near_misses: int = 0
    _near: set[str] = field(default_factory=set)
    _last: Status | None = None

    def update(self, status: Status) -> None:
        """Take one tick's status."""
        dt = 0.0 if self._last is None else status.time_s - self._last.time_s
        self._last = status
        if status.speed_mps < STANDING_MPS:
            self.standing_s += dt
            self.standing_run_s += dt
        else:
            self.standing_run_s = 0.0
        trigger = self.detector.update(status)
        self._span(status, trigger, dt)
        self._recovery(status, trigger)

    def _span(self, status: Status, trigger: Trigger | None, dt: float) -> None:
        if trigger is None:
            return
        if self.stuck and status.time_s - self.stuck[-1][1] <= dt + 1e-6:
            self.stuck[-1] = (self.stuck[-1][0], status.time_s)
        else:
            since = self.detector.slow_since_s
            self.stuck.append((status.time_s if since is None else since, status.time_s))

    def _recovery(self, status: Status, trigger: Trigger | None) -> None:
        was_on = self.watch.on
        recovered_after_s = self.watch.update(status, self.detector.slow_since_s, trigger)
        self.immobilizations += self.watch.on and not was_on
        if recovered_after_s is not None:
            self.recovery_times_s.append(recovered_after_s)

    def look(self, ego: EgoState, objects: tuple[TrackedObject, ...]) -> list[str]:
        """Count new near misses: a gap below 0.3 m to a moving actor (a collision has its own count)."""
        near: set[str] = set()
        for o in objects:
            if np.hypot(o.vx_mps, o.vy_mps) < STANDING_MPS or np.hypot(o.x_m - ego.x_m, o.y_m - ego.y_m) > 15.0:
                continue
            gap = separation(
                (ego.x_m, ego.y_m, ego.yaw_rad),
                (ego.length_m / 2, ego.width_m / 2),
                (o.x_m, o.y_m, o.yaw_rad),
                (o.length_m / 2, o.width_m / 2),
            )
            if float(gap) < NEAR_MISS_M:
                near.add(o.id)
        new = near - self._near
        self.near_misses += len(new)
        self._near = near
        return [f"near miss with {o}" for o in sorted(new)]

    @property
    def completion_pct(self) -> float:
        if self._last is None:
            return 0.0
        done = (self._last.progress_m - self.start_m) / max(self.length_m, 1e-6)
        return 100.0 if self._last.at_destination else round(min(max(100 * done, 0.0), 100.0), 2)
