"""Collects data of a CARLA world for the solver's process: raw numbers, sent only on request."""

from __future__ import annotations

import math
from typing import Any, Sequence

from stucksolver_bridge.actor_boxes import ATTRIBUTES, ActorBoxes, BridgeActorBox

ROUNDING_M = 0.001
"""Change of an arc length at which a waypoint is searched a second and a third time (m). Ours."""


class WorldData:
    """Data of one ego and its world. Poses are in CARLA's world frame: m, degrees, y to the right of x."""

    def __init__(self, vehicle: Any, carla_map: Any) -> None:
        self._vehicle = vehicle
        self._world = vehicle.get_world()
        self._map = carla_map
        self._boxes = ActorBoxes(self._world, vehicle.id)
        self._described_ids: set[int] = set()
        actors = self._world.get_actors()
        self._lights = list(actors.filter("*traffic_light*"))
        self._signs = list(actors.filter("*traffic.stop*"))

    def opening(self, route: Sequence[Any], acceleration_mps2: float) -> dict[str, Any]:
        """Return the data for the start.

        These are the map, the ego's size and acceleration from rest, the stop lines of all lights, the stop signs, the
        route and the first tick.
        """
        box = self._vehicle.bounding_box.extent
        return {
            "map": self._map.name.rsplit("/", 1)[-1],
            "xodr": self._map.to_opendrive(),
            "id": self._vehicle.id,
            "extent": [box.x, box.y, box.z],
            "acceleration": acceleration_mps2,
            "lights": [[light.id, [waypoint_numbers(w) for w in light.get_stop_waypoints()]] for light in self._lights],
            "stop_signs": [sign_places(sign) for sign in self._signs],
            "route": route_places(route),
            "tick": self.tick(),
        }

    def tick(self) -> dict[str, Any]:
        """Return the data for every tick: the time, the ego's motion and the speed limit."""
        stamp = self._world.get_snapshot()
        return {
            "time": stamp.timestamp.elapsed_seconds,
            "frame": stamp.frame,
            "ego": _motion(self._vehicle),
            "limit": self._vehicle.get_speed_limit(),
        }

    def give(self, what: str) -> Any:
        """Return the data that the solver requests by name; None if the name is not one of this class's requests."""
        if what == "actors":
            return self._actors()
        if what == "vehicle_lights":
            return {str(i): int(state) for i, state in self._world.get_vehicles_light_states().items()}
        if what == "light_state":
            return int(self._vehicle.get_light_state())
        return None

    def _actors(self) -> dict[str, Any]:
        """Return poses and motions of all boxes, descriptions of new ones, the lights' states, and the tick.

        A late request is answered with the current state.
        """
        snapshot = self._world.get_snapshot()
        rows, new = [], {}
        bodies = self._boxes.refresh(snapshot)
        for actor_id, body in bodies.items():
            actor = snapshot.find(actor_id)
            if actor is None:
                continue
            rows.append([actor_id, *_motion(actor)])
            if actor_id not in self._described_ids:
                new[str(actor_id)] = _description(body)
        self._described_ids = set(bodies)
        states = {str(light.id): str(light.state.name) for light in self._lights}
        return {"at": rows, "new": new, "states": states, "tick": self.tick()}


def route_places(route: Sequence[Any]) -> list[Any]:
    """Return the road, lane, arc length and command of each point of a route."""
    return [[*waypoint_numbers(point.waypoint), point.command] for point in route]


def waypoint_numbers(waypoint: Any) -> list[Any]:
    """Return road, lane and arc length of a `carla.Waypoint`, from which `waypoint_at` restores it."""
    return [waypoint.road_id, waypoint.lane_id, waypoint.s]


def waypoint_at(carla_map: Any, position: Sequence[Any]) -> Any | None:
    """Return the waypoint at a road, lane and arc length; None without one within a millimeter.

    `carla.Map.get_waypoint_xodr` finds nothing at the very end of some roads, although other calls return waypoints
    there: the road's length in the map and the sum of its geometry's lengths differ in the last digits.
    """
    road, lane, s = position[:3]
    for nearby_s in (s, max(s - ROUNDING_M, 0.0), s + ROUNDING_M):
        waypoint = carla_map.get_waypoint_xodr(road, lane, nearby_s)
        if waypoint is not None:
            return waypoint
    return None


def waypoints_at(carla_map: Any, positions: Sequence[Any]) -> list[tuple[Any, Any]]:
    """Return the waypoint and the command of each point of `route_places`; points that are not found are left out."""
    pairs = [(waypoint_at(carla_map, position), position[3]) for position in positions]
    return [(waypoint, command) for waypoint, command in pairs if waypoint is not None]


def _motion(actor: Any) -> list[float]:
    velocity = actor.get_velocity()
    return [*_pose(actor), velocity.x, velocity.y, velocity.z]


def _pose(actor: Any) -> list[float]:
    transform = actor.get_transform()
    location, rotation = transform.location, transform.rotation
    return [location.x, location.y, location.z, rotation.pitch, rotation.yaw, rotation.roll]


def sign_places(sign: Any) -> list[list[float]]:
    """Return a sign's pose, and the center and half sizes of its trigger box in the sign's frame."""
    volume = sign.trigger_volume
    center, half = volume.location, volume.extent
    return [_pose(sign), [center.x, center.y, center.z], [half.x, half.y, half.z]]


def _description(body: BridgeActorBox) -> dict[str, Any]:
    actor = body.actor
    attributes = actor.attributes
    return {
        "type": actor.type_id,
        "attributes": {name: str(attributes[name]) for name in ATTRIBUTES if name in attributes},
        "extent": [body.half_length_m, body.half_width_m, body.half_height_m],
        "offset": list(body.offset),
        "yaw": math.degrees(body.yaw_rad),
    }
