"""Tracks the objects around the ego from the client's ground truth: what they are, and since when they stand.

This is the `privileged` perception; a sensor-based one returns the same `TrackedObject`s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from stucksolver.scene import ObjectKind, TrackedObject
from stucksolver_carla.drivers.behavior.nearby_objects import HAZARD_LAMPS, GroundTruthObjects
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects as Seen
from stucksolver_carla.stack.contact import EgoFootprint, PushDetector
from stucksolver_carla.stack.object_kinds import attributes_of, kind_of

if TYPE_CHECKING:
    import carla

RANGE_M = 300.0
STANDING_MPS = 0.1
LIGHTS_EVERY_S = 0.5
_BRAKE = 8
_EMERGENCY = 512 | 1024
"""`carla.VehicleLightState.Special1` and `Special2`: the roof lights."""
GROUND_TRUTH = 1.0
"""The client's kinds are certain."""


@dataclass
class _Track:
    kind: ObjectKind
    first_seen_s: float
    standing_since_s: float | None = None
    last_moved_s: float | None = None
    lights: int | None = field(default=None)
    pushed: bool = False


class Tracker:
    """Call `update` now and then (twice a second is enough), and `objects` when they are wanted."""

    def __init__(self, world: carla.World, ego_id: int, range_m: float = RANGE_M) -> None:
        self._world = world
        self._perception = GroundTruthObjects(world, ego_id, range_m)
        self._tracks: dict[int, _Track] = {}
        self._lights_read_s = -math.inf
        self._pushing = PushDetector()

    @property
    def pushes(self) -> bool:
        """True if the ego pushed something at the last look."""
        return bool(self._pushing.now)

    def watch(self, ego: EgoFootprint, now_s: float) -> Seen:
        """Look around and note who moves by itself; cheap."""
        seen = self._perception.read(ego.x, ego.y)
        self._meet(seen.actor_id, now_s)
        pushed = self._pushing.look(ego, seen)
        moving = np.hypot(seen.vx, seen.vy) > STANDING_MPS
        for actor_id, moves in zip(seen.actor_id, moving.tolist(), strict=True):
            track = self._tracks.get(actor_id)
            if track is not None:
                track.pushed = moves and actor_id in pushed
                self._move(track, moves and not track.pushed, now_s)
        return seen

    def update(self, ego: EgoFootprint, now_s: float) -> tuple[TrackedObject, ...]:
        """Return everything within range of the ego, in the local frame."""
        seen = self.watch(ego, now_s)
        objects = []
        for i, actor_id in enumerate(seen.actor_id):
            track = self._tracks.get(actor_id)
            if track is not None:
                objects.append(_tracked(seen, i, track, now_s))
        return tuple(objects)

    def read_lights(self, now_s: float) -> None:
        """Refresh the lights of all vehicles, at most twice a second: it costs a call to the server."""
        if now_s - self._lights_read_s < LIGHTS_EVERY_S:
            return
        self._lights_read_s = now_s
        for actor_id, state in self._world.get_vehicles_light_states().items():
            track = self._tracks.get(actor_id)
            if track is not None:
                track.lights = int(state)

    def _meet(self, ids: tuple[int, ...], now_s: float) -> None:
        new = [i for i in ids if i not in self._tracks]
        if new:
            for actor in self._world.get_actors(new):
                kind = kind_of(actor.type_id, attributes_of(actor))
                self._tracks[actor.id] = _Track(kind, now_s)
        gone = self._tracks.keys() - set(ids)
        for actor_id in gone:
            del self._tracks[actor_id]

    @staticmethod
    def _move(track: _Track, moving: bool, now_s: float) -> None:
        if moving:
            track.last_moved_s, track.standing_since_s = now_s, None
        elif track.standing_since_s is None:
            track.standing_since_s = now_s


def _tracked(seen: Seen, i: int, track: _Track, now_s: float) -> TrackedObject:
    return TrackedObject(
        id=str(seen.actor_id[i]),
        kind=track.kind,
        x_m=float(seen.x[i]),
        y_m=-float(seen.y[i]),
        yaw_rad=-float(seen.yaw[i]),
        vx_mps=float(seen.vx[i]),
        vy_mps=-float(seen.vy[i]),
        length_m=2 * float(seen.half_length[i]),
        width_m=2 * float(seen.half_width[i]),
        height_m=float(seen.top[i] - seen.bottom[i]),
        stationary_s=0.0 if track.standing_since_s is None else now_s - track.standing_since_s,
        moved_s_ago=None if track.last_moved_s is None else now_s - track.last_moved_s,
        seen_for_s=now_s - track.first_seen_s,
        pushed=track.pushed,
        kind_confidence=GROUND_TRUTH,
        hazard_lights=None if track.lights is None else track.lights & HAZARD_LAMPS == HAZARD_LAMPS,
        emergency_lights=None if track.lights is None else bool(track.lights & _EMERGENCY),
        brake_lights=None if track.lights is None else bool(track.lights & _BRAKE),
    )
