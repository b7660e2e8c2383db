"""Ground truth around a vehicle, in the local frame: objects, lamps, doors and traffic lights."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import carla
import numpy as np

from stucksolver.scene import ObjectKind
from stucksolver.scene.objects import Gesture
from stucksolver_carla.drivers.behavior.nearby_objects import BODILESS, ActorBox, body_of
from stucksolver_carla.stack.carla_frames import to_local, yaw_to_local
from stucksolver_carla.stack.object_kinds import attributes_of, kind_of
from stucksolver_perception.measurements import Floats
from stucksolver_perception.recording import BOX_COLUMNS, GESTURES, KINDS, LightTruth, Truth

RANGE_M = 250.0
"""Distance up to which objects are recorded (m)."""
LIGHTS_WITHIN_M = 120.0
"""Distance up to which traffic lights are recorded (m)."""
_DEEP_M = 40.0
"""Depth below the ego from which on an actor is a waiting one of a staged scene (m). Ours."""
_FLAGGER = "walker.flagger"
_UNKNOWN = -1
"""Value of an unknown property."""
_STATES = {
    carla.TrafficLightState.Red: 0,
    carla.TrafficLightState.Yellow: 1,
    carla.TrafficLightState.Green: 2,
    carla.TrafficLightState.Off: 3,
}
"""Numbers of the states of lights in a recording."""
_UNKNOWN_STATE = 4
"""Number of an unknown state."""

DoorsOpen = Callable[[int], int]
"""Returns the open doors of the vehicle with this id as bits, see `Truth.doors`.

The client API cannot report them.
"""


@dataclass(frozen=True)
class _ActorConstants:
    """The constant properties of an actor."""

    body: ActorBox
    kind: int
    type_id: str
    has_lamps: bool
    gesture: int


class TruthReader:
    """Reads the world around one vehicle. The server is queried for actors only if the set of ids changes."""

    def __init__(self, world: carla.World, ego_id: int, doors_open: DoorsOpen | None = None) -> None:
        self._world, self._ego_id, self._doors_open = world, ego_id, doors_open
        self._known: dict[int, _ActorConstants | None] = {}

    def read(self, snapshot: carla.WorldSnapshot) -> Truth:
        """Return all objects within `RANGE_M` of the ego at the current tick's snapshot.

        Raises:
            RuntimeError: An actor is missing in the snapshot.
        """
        self._meet(snapshot)
        ego = in_snapshot(snapshot, self._ego_id).get_transform().location
        lamps = {int(actor): int(state) for actor, state in self._world.get_vehicles_light_states().items()}
        rows, ids = [], []
        for actor_id, known in self._known.items():
            actor = None if known is None else snapshot.find(actor_id)
            if known is None or actor is None:
                continue
            row = _row(known.body, actor)
            if math.hypot(row[0] - ego.x, row[1] + ego.y) < RANGE_M and row[2] > ego.z - _DEEP_M:
                rows.append(row)
                ids.append((actor_id, known))
        return Truth(
            np.array([actor_id for actor_id, _ in ids], np.int64),
            np.array([known.kind for _, known in ids], np.int64),
            np.array(rows, np.float64).reshape(-1, len(BOX_COLUMNS)),
            np.array([lamps.get(number, 0) if known.has_lamps else -1 for number, known in ids], np.int64),
            np.array([self._doors(number, known) for number, known in ids], np.int64),
            np.array([known.gesture for _, known in ids], np.int64),
            np.full(len(ids), _UNKNOWN, np.int64),
            tuple(known.type_id for _, known in ids),
        )

    def _doors(self, actor_id: int, known: _ActorConstants) -> int:
        if self._doors_open is None or not known.type_id.startswith("vehicle."):
            return _UNKNOWN
        return self._doors_open(actor_id)

    def _meet(self, snapshot: carla.WorldSnapshot) -> None:
        ids = frozenset(actor.id for actor in snapshot)
        for gone in self._known.keys() - ids:
            del self._known[gone]
        new = ids - self._known.keys()
        if new:
            # An id that the server does not list yet is queried again on the next tick.
            self._known.update({actor.id: self._measure(actor) for actor in self._world.get_actors(list(new))})

    def _measure(self, actor: carla.Actor) -> _ActorConstants | None:
        if actor.id == self._ego_id or actor.type_id.startswith(BODILESS):
            return None
        body = body_of(actor)
        if body is None:
            return None
        kind, has_lamps = KINDS.index(_kind(actor)), actor.attributes.get("has_lights") == "true"
        return _ActorConstants(body, kind, str(actor.type_id), has_lamps, _gesture(actor))


class LightsReader:
    """Reads the traffic lights of a world. Their heads are queried once."""

    def __init__(self, world: carla.World) -> None:
        lights = world.get_actors().filter("traffic.traffic_light*")
        self._lights = [(light, _heads(light)) for light in lights]

    def read(self, x_m: float, y_m: float) -> LightTruth:
        """Return the lights within `LIGHTS_WITHIN_M` of a position in the local frame (m)."""
        near = [(light, heads) for light, heads in self._lights if _reach(heads, x_m, y_m) < LIGHTS_WITHIN_M]
        return LightTruth(
            np.array([light.id for light, _ in near], np.int64),
            np.array([_STATES.get(light.state, _UNKNOWN_STATE) for light, _ in near], np.int64),
            tuple(heads for _, heads in near),
        )


def in_snapshot(snapshot: carla.WorldSnapshot, actor_id: int) -> carla.ActorSnapshot:
    """Return the state of an actor.

    Raises:
        RuntimeError: The actor is missing.
    """
    found = snapshot.find(actor_id)
    if found is None:
        raise RuntimeError(f"actor {actor_id} is missing in the world; the recording of the drive cannot continue")
    return found


def ego_pose(actor: carla.ActorSnapshot) -> Floats:
    """Return the pose of a vehicle in a snapshot as in `Recorded.pose`, shape (9,); pitch is positive nose down."""
    transform, velocity, turning = actor.get_transform(), actor.get_velocity(), actor.get_angular_velocity()
    place, turn = transform.location, transform.rotation
    x, y = to_local(place)
    yaw = yaw_to_local(turn.yaw)
    vx, vy = velocity.x, -velocity.y
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array(
        [
            *(x, y, place.z, math.remainder(yaw, math.tau)),
            *(-math.radians(turn.pitch), math.radians(turn.roll)),
            *(vx * cos + vy * sin, -math.radians(turning.z), -vx * sin + vy * cos),
        ]
    )


def _kind(actor: carla.Actor) -> ObjectKind:
    """Return the actor's kind as in the stack, except for flaggers, which perception must recognize."""
    if actor.type_id.startswith(_FLAGGER):
        return ObjectKind.FLAGGER
    return kind_of(actor.type_id, attributes_of(actor))


def _gesture(actor: carla.Actor) -> int:
    """Return the index of a flagger's gesture, which carlette's blueprint has as an attribute."""
    gesture = actor.attributes.get("gesture")
    return _UNKNOWN if gesture is None else GESTURES.index(Gesture(gesture))


def _row(body: ActorBox, actor: carla.ActorSnapshot) -> tuple[float, ...]:
    """Return an object's row with the columns `BOX_COLUMNS`."""
    transform, velocity = actor.get_transform(), actor.get_velocity()
    # The client's stub declares vectors. In fact a location is transformed to a location.
    middle: Any = transform.transform(carla.Location(*body.offset))
    x, y = to_local(middle)
    yaw = math.remainder(yaw_to_local(transform.rotation.yaw) - body.yaw, math.tau)
    size = (2.0 * body.half_length, 2.0 * body.half_width, 2.0 * body.half_height)
    return (x, y, middle.z, yaw, *size, velocity.x, -velocity.y)


def _heads(light: carla.TrafficLight) -> Floats:
    rows = []
    for box in light.get_light_boxes():
        x, y = to_local(box.location)
        half = box.extent
        rows.append((x, y, box.location.z, half.x, half.y, half.z, yaw_to_local(box.rotation.yaw)))
    return np.array(rows, np.float64).reshape(-1, 7)


def _reach(heads: Floats, x_m: float, y_m: float) -> float:
    if not len(heads):
        return math.inf
    away: Any = np.hypot(heads[:, 0] - x_m, heads[:, 1] - y_m)
    return float(away.min())
