"""Facts about a CARLA world for the solver's process: raw numbers, sent only on request."""

from __future__ import annotations

import math
from typing import Any, Sequence

from stucksolver_bridge.actor_boxes import ATTRIBUTES, ActorBoxes, BridgeActorBox

ROUNDING_M = 0.001


class WorldData:
    """Facts about one ego in a client's world. Poses are in CARLA's frame: meters, degrees, y to the right of x."""

    def __init__(self, vehicle: Any, carla_map: Any) -> None:
        self._vehicle = vehicle
        self._world = vehicle.get_world()
        self._map = carla_map
        self._bodies = ActorBoxes(self._world, vehicle.id)
        self._told: set[int] = set()
        actors = self._world.get_actors()
        self._lights = list(actors.filter("*traffic_light*"))
        self._signs = list(actors.filter("*traffic.stop*"))

    def opening(self, route: Sequence[Any], acceleration_mps2: float) -> dict[str, Any]:
        """Return what is sent once at the start: the map, the ego's size and acceleration from rest, the stop lines of
        all lights, the stop signs, the route and the first tick."""
        box = self._vehicle.bounding_box.extent
        return {
            "map": self._map.name.rsplit("/", 1)[-1],
            "xodr": self._map.to_opendrive(),
            "id": self._vehicle.id,
            "extent": [box.x, box.y, box.z],
            "acceleration": acceleration_mps2,
            "lights": [[light.id, [place(w) for w in light.get_stop_waypoints()]] for light in self._lights],
            "stop_signs": [sign_places(sign) for sign in self._signs],
            "route": route_places(route),
            "tick": self.tick(),
        }

    def tick(self) -> dict[str, Any]:
        """Return what is sent on every tick: the time and the ego's motion."""
        stamp = self._world.get_snapshot()
        return {
            "time": stamp.timestamp.elapsed_seconds,
            "frame": stamp.frame,
            "ego": _motion(self._vehicle),
            "limit": self._vehicle.get_speed_limit(),
        }

    def give(self, what: str) -> Any:
        """Return what the solver asks for by name; None if the name is unknown here."""
        if what == "actors":
            return self._actors()
        if what == "vehicle_lights":
            return {str(i): int(state) for i, state in self._world.get_vehicles_light_states().items()}
        if what == "light_state":
            return int(self._vehicle.get_light_state())
        return None

    def _actors(self) -> dict[str, Any]:
        """Return pose and motion of every body, descriptions of new bodies, the lights' states, and the tick. A late
        request is answered with the current state."""
        snapshot = self._world.get_snapshot()
        rows, new = [], {}
        bodies = self._bodies.refresh(snapshot)
        for actor_id, body in bodies.items():
            actor = snapshot.find(actor_id)
            if actor is None:
                continue
            rows.append([actor_id, *_motion(actor)])
            if actor_id not in self._told:
                new[str(actor_id)] = _kind(body)
        self._told = set(bodies)
        states = {str(light.id): str(light.state.name) for light in self._lights}
        return {"at": rows, "new": new, "states": states, "tick": self.tick()}


def route_places(route: Sequence[Any]) -> list[Any]:
    """Return the road, lane, arc length and command of each point of a route."""
    return [[*place(point.waypoint), point.command] for point in route]


def place(waypoint: Any) -> list[Any]:
    """Return a `carla.Waypoint` as numbers from which `waypoint_at` finds it again."""
    return [waypoint.road_id, waypoint.lane_id, waypoint.s]


def waypoint_at(carla_map: Any, spot: Sequence[Any]) -> Any | None:
    """Return the waypoint at a road, lane and arc length; None if there is none within a millimeter.

    `carla.Map.get_waypoint_xodr` finds nothing at the very end of some roads, although other calls return waypoints
    there: the road's length in the map and the sum of its geometry's lengths differ in the last digits.
    """
    road, lane, s = spot[:3]
    for nearby in (s, max(s - ROUNDING_M, 0.0), s + ROUNDING_M):
        found = carla_map.get_waypoint_xodr(road, lane, nearby)
        if found is not None:
            return found
    return None


def waypoints_at(carla_map: Any, spots: Sequence[Any]) -> list[tuple[Any, Any]]:
    """Return the waypoint and the command of each point of `route_places`; points that are not found are left out."""
    found = [(waypoint_at(carla_map, spot), spot[3]) for spot in spots]
    return [(waypoint, command) for waypoint, command in found if waypoint is not None]


def _motion(actor: Any) -> list[float]:
    velocity = actor.get_velocity()
    return [*_stands(actor), velocity.x, velocity.y, velocity.z]


def _stands(actor: Any) -> list[float]:
    transform = actor.get_transform()
    where, turn = transform.location, transform.rotation
    return [where.x, where.y, where.z, turn.pitch, turn.yaw, turn.roll]


def sign_places(sign: Any) -> list[list[float]]:
    """Return a sign's pose, and the center and half sizes of its trigger box in the sign's frame."""
    volume = sign.trigger_volume
    middle, half = volume.location, volume.extent
    return [_stands(sign), [middle.x, middle.y, middle.z], [half.x, half.y, half.z]]


def _kind(body: BridgeActorBox) -> dict[str, Any]:
    actor = body.actor
    known = actor.attributes
    return {
        "type": actor.type_id,
        "attributes": {name: str(known[name]) for name in ATTRIBUTES if name in known},
        "extent": [body.half_length_m, body.half_width_m, body.half_height_m],
        "offset": list(body.offset),
        "yaw": math.degrees(body.yaw_rad),
    }
