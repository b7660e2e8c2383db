"""Tracks the objects around the ego from the client's ground truth: their kinds and how long they have been stopped.

This is the `privileged` perception; sensor-based perception returns the same `TrackedObject`s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from stucksolver.scene import ObjectKind, TrackedObject
from stucksolver_carla.drivers.behavior.nearby_objects import HAZARD_LAMPS, GroundTruthObjects, NearbyObjects
from stucksolver_carla.stack.contact import EgoFootprint, PushDetector
from stucksolver_carla.stack.object_kinds import attributes_of, kind_of

if TYPE_CHECKING:
    import carla

RANGE_M = 300.0
"""Half size of the square around the ego in which objects are tracked (m). Ours."""
STOPPED_MPS = 0.1
"""Speed below which an object counts as stopped (m/s). Ours."""
LIGHTS_PERIOD_S = 0.5
"""Minimum time between two requests of the vehicles' lamps (s). Ours."""
_BRAKE_LAMP = 8
"""`carla.VehicleLightState.Brake`."""
_EMERGENCY = 512 | 1024
"""`carla.VehicleLightState.Special1` and `Special2`: the roof lights."""
CERTAIN = 1.0
"""Confidence of the client's kinds, which are ground truth."""


@dataclass
class _Track:
    kind: ObjectKind
    first_seen_s: float
    stopped_since_s: float | None = None
    last_moved_s: float | None = None
    lights: int | None = field(default=None)
    pushed: bool = False


class Tracker:
    """The tracker. Call `watch` about twice per second, and `update` for the objects."""

    def __init__(self, world: carla.World, ego_id: int, range_m: float = RANGE_M) -> None:
        self._world = world
        self._perception = GroundTruthObjects(world, ego_id, range_m)
        self._tracks: dict[int, _Track] = {}
        self._lights_read_s = -math.inf
        self._push_detector = PushDetector()

    @property
    def pushes(self) -> bool:
        """True if the ego pushed an object at the last update."""
        return bool(self._push_detector.pushed_ids)

    def watch(self, ego: EgoFootprint, now_s: float) -> NearbyObjects:
        """Update which objects move by themselves, and return all boxes within range. The call is cheap."""
        boxes = self._perception.read(ego.x, ego.y)
        self._update_ids(boxes.actor_id, now_s)
        pushed = self._push_detector.update(ego, boxes)
        moving = np.hypot(boxes.vx, boxes.vy) > STOPPED_MPS
        for actor_id, moves in zip(boxes.actor_id, moving.tolist(), strict=True):
            track = self._tracks.get(actor_id)
            if track is not None:
                track.pushed = moves and actor_id in pushed
                self._update_motion(track, moves and not track.pushed, now_s)
        return boxes

    def update(self, ego: EgoFootprint, now_s: float) -> tuple[TrackedObject, ...]:
        """Return all objects within range of the ego, in the local frame."""
        boxes = self.watch(ego, now_s)
        objects = []
        for i, actor_id in enumerate(boxes.actor_id):
            track = self._tracks.get(actor_id)
            if track is not None:
                objects.append(_tracked(boxes, i, track, now_s))
        return tuple(objects)

    def read_lights(self, now_s: float) -> None:
        """Read the lights of all vehicles, at most twice per second, because each time is a request to the server."""
        if now_s - self._lights_read_s < LIGHTS_PERIOD_S:
            return
        self._lights_read_s = now_s
        for actor_id, state in self._world.get_vehicles_light_states().items():
            track = self._tracks.get(actor_id)
            if track is not None:
                track.lights = int(state)

    def _update_ids(self, ids: tuple[int, ...], now_s: float) -> None:
        new_ids = [i for i in ids if i not in self._tracks]
        if new_ids:
            for actor in self._world.get_actors(new_ids):
                kind = kind_of(actor.type_id, attributes_of(actor))
                self._tracks[actor.id] = _Track(kind, now_s)
        removed_ids = self._tracks.keys() - set(ids)
        for actor_id in removed_ids:
            del self._tracks[actor_id]

    @staticmethod
    def _update_motion(track: _Track, moving: bool, now_s: float) -> None:
        if moving:
            track.last_moved_s, track.stopped_since_s = now_s, None
        elif track.stopped_since_s is None:
            track.stopped_since_s = now_s


def _tracked(boxes: NearbyObjects, i: int, track: _Track, now_s: float) -> TrackedObject:
    return TrackedObject(
        id=str(boxes.actor_id[i]),
        kind=track.kind,
        x_m=float(boxes.x[i]),
        y_m=-float(boxes.y[i]),
        yaw_rad=-float(boxes.yaw[i]),
        vx_mps=float(boxes.vx[i]),
        vy_mps=-float(boxes.vy[i]),
        length_m=2 * float(boxes.half_length[i]),
        width_m=2 * float(boxes.half_width[i]),
        height_m=float(boxes.top[i] - boxes.bottom[i]),
        stationary_s=0.0 if track.stopped_since_s is None else now_s - track.stopped_since_s,
        moved_s_ago=None if track.last_moved_s is None else now_s - track.last_moved_s,
        seen_for_s=now_s - track.first_seen_s,
        pushed=track.pushed,
        kind_confidence=CERTAIN,
        hazard_lights=None if track.lights is None else track.lights & HAZARD_LAMPS == HAZARD_LAMPS,
        emergency_lights=None if track.lights is None else bool(track.lights & _EMERGENCY),
        brake_lights=None if track.lights is None else bool(track.lights & _BRAKE_LAMP),
    )
